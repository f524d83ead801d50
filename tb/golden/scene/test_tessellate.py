import numpy as np
import pytest

from golden.base.errors import InputError
from golden.scene.tessellate import bezier, frustum, revolution, sphere, square
from tb.golden.scene.closed import assert_closed, assert_good_patches


def area_vectors(patches):
    return 0.5 * np.cross(patches[:, 2] - patches[:, 0], patches[:, 3] - patches[:, 1])


def volume(patches):
    """Of a closed surface, by the divergence theorem; positive if the fronts are outside."""
    return (area_vectors(patches) * patches.mean(axis=1)).sum() / 3


@pytest.mark.parametrize("segments", [3, 4, 5, 8, 17, 32])
def test_sphere_is_closed_and_faces_outwards(segments):
    patches = sphere((1.0, -2.0, 0.3), 0.7, segments=segments)
    assert_closed(patches)
    assert_good_patches(patches, 1.4)
    outward = np.einsum("ij,ij->i", area_vectors(patches), patches.mean(axis=1) - (1.0, -2.0, 0.3))
    assert outward.min() > 0
    assert np.linalg.norm(patches - (1.0, -2.0, 0.3), axis=2) == pytest.approx(0.7, abs=1e-15)


def test_sphere_converges_to_the_volume_of_a_ball():
    errors = [1 - volume(sphere((0, 0, 0), 1.0, segments=n)) / (4 / 3 * np.pi) for n in (16, 32, 64)]
    assert errors[0] > errors[1] > errors[2] > 0
    assert errors[1] / errors[2] == pytest.approx(4, rel=0.02)


@pytest.mark.parametrize("radii", [(0.5, 0.5), (0.5, 0.2), (0.2, 0.5), (0.5, 0.0), (0.0, 0.5)])
@pytest.mark.parametrize("apex", [(0, 0, 2), (0, 0, -2), (3, 0, 0), (-1, 2, 0.5)])
def test_frustum_is_the_side_between_two_circles(radii, apex):
    a, b = radii
    n = 12
    patches = frustum((0.0, 0.0, 0.0), apex, a, b, segments=n)
    assert_good_patches(patches, 2)
    polygon = 0.5 * n * np.sin(2 * np.pi / n)
    # The end around the origin adds nothing to the volume; that around the apex is left out too.
    expected = polygon * np.linalg.norm(apex) * (a * a + a * b) / 3
    assert volume(patches) == pytest.approx(expected, rel=1e-12, abs=1e-15)
    assert len(patches) == n


def test_revolution_of_a_ring_is_closed():
    profile = [(1, 0), (1.5, 0.2), (1.5, 0.8), (1, 1), (1, 0)]
    patches = revolution(profile, segments=10)
    assert_closed(patches)
    assert_good_patches(patches, 3)
    assert volume(patches) > 0


def test_square_has_its_center_side_and_front():
    patches = square((1.0, 2.0, 3.0), 4.0, facing=(0.0, -2.0, 0.0), cuts=3)
    assert len(patches) == 9
    assert area_vectors(patches).sum(axis=0) == pytest.approx((0, -16, 0))
    points = patches.reshape(-1, 3)
    assert points.min(axis=0).tolist() == [-1, 2, 1]
    assert points.max(axis=0).tolist() == [3, 2, 5]
    assert len(np.unique(points, axis=0)) == 16


def random_control(seed):
    return np.random.default_rng(seed).normal(size=(4, 4, 3)) + 3 * np.stack(
        (*np.meshgrid(np.arange(4.0), np.arange(4.0), indexing="ij"), np.zeros((4, 4))), axis=2)


def corners_on_border(control, cuts):
    """Those of the first row of cells, in any order."""
    points = bezier(control, cuts=cuts).reshape(-1, 3)
    curve = bezier_curve(control[0], np.arange(cuts + 1) / cuts)
    near = np.abs(points[:, None] - curve).max(axis=2).min(axis=1) < 1e-9
    return np.unique(points[near], axis=0)


def bezier_curve(points, t):
    s = 1 - t
    return np.stack((s**3, 3 * t * s**2, 3 * t**2 * s, t**3), axis=1) @ points


@pytest.mark.parametrize("turn", range(8))
def test_bezier_neighbours_share_the_border_to_the_bit(turn):
    """For all inner points and both directions of the shared border."""
    one, other = random_control(1), random_control(2)
    other[0] = one[0]
    turned = np.rot90(other if turn < 4 else other.swapaxes(0, 1), turn % 4)
    for cuts in (1, 3, 7):
        expected = corners_on_border(one, cuts)
        assert len(expected) == cuts + 1
        points = {tuple(point) for point in bezier(turned, cuts=cuts).reshape(-1, 3).tolist()}
        assert all(tuple(point) in points for point in expected.tolist())


def test_bezier_points_are_on_the_surface():
    control = random_control(3)
    expected = {tuple(np.round(bezier_curve(np.stack([bezier_curve(column, np.array([u]))[0] for column in
                                                      control.swapaxes(0, 1)]), np.array([v]))[0], 9))
                for u in np.arange(6) / 5 for v in np.arange(6) / 5}
    assert {tuple(point) for point in np.round(bezier(control, cuts=5).reshape(-1, 3), 9).tolist()} == expected


def test_bezier_keeps_planar_cells_as_quads_and_cuts_twisted_ones():
    flat = 0.0 + np.stack((*np.meshgrid(np.arange(4.0), np.arange(4.0), indexing="ij"), np.zeros((4, 4))), axis=2)
    assert len(bezier(flat, cuts=4)) == 16
    assert area_vectors(bezier(flat, cuts=4)).sum(axis=0).tolist() == [0, 0, 9]
    twisted = flat.copy()
    twisted[3, 3, 2] = 1e-6
    assert len(bezier(twisted, cuts=4)) == 32


def test_bezier_collapsed_border_gives_triangles_with_area():
    control = random_control(4)
    control[0] = control[0, 0]
    patches = bezier(control, cuts=5)
    assert np.linalg.norm(area_vectors(patches), axis=1).min() > 1e-3
    assert len(patches) == 2 * 25 - 5
    assert (patches == control[0, 0]).all(axis=2).any(axis=1).sum() == 5


@pytest.mark.parametrize(("call", "message"), [
    (lambda: sphere((0, 0, 0), 0.0), "Radius must be a finite value above 0, not 0.0"),
    (lambda: sphere((0, 0, 0), -1.0), "Radius must be a finite value above 0, not -1.0"),
    (lambda: frustum((0, 0, 0), (0, 0, 0), 1, 1), "Apex must be away from the base, not at (0.0, 0.0, 0.0) as well"),
    (lambda: frustum((0, 0, 0), (0, 0, 1), 0, 0), "Base radius must be above 0 where the apex radius is 0, not 0"),
    (lambda: frustum((0, 0, 0), (0, 0, 1), 1, -1), "Apex radius must be a finite value of at least 0, not -1"),
])
def test_bad_argument_is_named(call, message):
    with pytest.raises(InputError) as caught:
        call()
    assert str(caught.value) == message
