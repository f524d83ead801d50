import numpy as np
import pytest

from golden.light.surface_points import SurfacePoints, bilinear, corner_normals
from golden.scene.tessellate import sphere
from tb.golden.light.scenes import BLACK, rectangle, scene_of

SMOOTH = {"smooth": True}
FLOOR = rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0))
WALL = rectangle((0, 0, 0), (0, 1, 0), (0, 0, 1))


@pytest.mark.parametrize("segments", [12, 24, 48])
def test_normals_of_a_tessellated_sphere_point_outwards(segments):
    """The errors fall with the size of the facets, away from the poles, where all neighbours are alike, its square."""
    centre = np.array((1.0, 2.0, 3.0))
    scene = scene_of((sphere(centre, 2.0, segments=segments), BLACK, SMOOTH))
    normals = corner_normals(scene)
    np.testing.assert_allclose(np.linalg.norm(normals, axis=2), 1, rtol=0, atol=1e-12)
    radial = (scene.vertices - centre) / 2
    error = np.arccos(np.clip(np.einsum("nkj,nkj->nk", normals, radial), -1, 1))
    facet = 2 * np.pi / segments
    assert error.max() < facet / 4
    assert error[np.abs(radial[..., 2]) < 0.71].max() < facet**2 / 3


def test_patches_that_are_not_smooth_keep_their_own_normals():
    scene = scene_of((sphere((0, 0, 0), 1.0, segments=8), BLACK))
    np.testing.assert_array_equal(corner_normals(scene), np.repeat(scene.normals[:, None], 4, axis=1))


def test_smooth_groups_do_not_mix():
    scene = scene_of((FLOOR, BLACK, SMOOTH), (WALL, BLACK, SMOOTH))
    np.testing.assert_allclose(corner_normals(scene), np.repeat(scene.normals[:, None], 4, axis=1), rtol=0, atol=1e-15)


def test_patches_that_meet_share_the_mean_weighted_by_area_there_and_only_there():
    scene = scene_of((np.array([FLOOR, WALL * (1, 1, 3)]), BLACK, SMOOTH))
    normals = corner_normals(scene)
    shared = np.array((3, 0, 1)) / np.sqrt(10)
    np.testing.assert_allclose(normals[0], [shared, (0, 0, 1), (0, 0, 1), shared], rtol=0, atol=1e-15)
    np.testing.assert_allclose(normals[1], [shared, shared, (1, 0, 0), (1, 0, 0)], rtol=0, atol=1e-15)


@pytest.mark.parametrize("turn", range(3))
def test_a_triangle_counts_once_at_every_corner(turn):
    triangle = np.roll(np.array([(0, 0, 0), (2, 0, 0), (0, 1, 0)], dtype=float), turn, axis=0)[[0, 1, 2, 2]]
    scene = scene_of((np.array([triangle, WALL]), BLACK, SMOOTH))
    normals = corner_normals(scene)
    np.testing.assert_allclose(normals[1, 0], np.array((1, 0, 1)) / np.sqrt(2), rtol=0, atol=1e-15)
    np.testing.assert_array_equal(normals[0, 2], normals[0, 3])


def test_zero_and_minus_zero_are_one_point():
    scene = scene_of((np.array([FLOOR, np.where(WALL == 0, -0.0, WALL)]), BLACK, SMOOTH))
    np.testing.assert_allclose(corner_normals(scene)[0, 0], np.array((1, 0, 1)) / np.sqrt(2), rtol=0, atol=1e-15)


def test_a_sheet_that_folds_back_on_itself_keeps_the_normals_of_its_sides():
    turned = (FLOOR + 0.3) @ np.linalg.qr(np.random.default_rng(4).normal(size=(3, 3)))[0]
    halves = [turned, turned[[2, 1, 0, 0]], turned[[3, 2, 0, 0]]]
    scene = scene_of((np.array(halves), BLACK, SMOOTH))
    assert scene.area_vectors.sum(axis=0).any(), "nothing remains but rounding"
    own = np.repeat(scene.normals[:, None], 4, axis=1)
    np.testing.assert_array_equal(corner_normals(scene)[0, [0, 2]], own[0, [0, 2]])


def test_bilinear_takes_the_corners_and_the_middle():
    corners = np.random.default_rng(2).normal(size=(1, 4, 5))
    u, v = np.array([0.0, 1, 1, 0, 0.5]), np.array([0.0, 0, 1, 1, 0.5])
    values = bilinear(corners.repeat(5, axis=0), u, v)
    np.testing.assert_allclose(values, np.append(corners[0], corners.mean(axis=1), axis=0), rtol=0, atol=1e-15)


def test_surface_points_are_taken_by_rows():
    points = SurfacePoints(np.arange(12.0).reshape(4, 3), np.ones((4, 3)), np.arange(4))
    some = points[np.array([2, 0])]
    assert len(points) == 4
    assert some.patch.tolist() == [2, 0]
    assert some.position[:, 0].tolist() == [6, 0]
