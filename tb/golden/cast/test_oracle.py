"""The oracle against closed forms, and no ray is lost between neighbours."""

import numpy as np
import pytest

from golden.cast.naive import Naive
from golden.cast.rays import Rays
from golden.scene.builder import SceneBuilder
from golden.scene.material import Material
from tb.golden.soups import closed_mesh, random_rays, soup


def one_patch(vertices):
    builder = SceneBuilder("patch")
    builder.add(vertices, Material(name="paint"))
    return builder.build()


def test_hit_of_a_square_has_the_plane_s_distance_and_its_uv():
    scene = one_patch([[0, 0, 1], [2, 0, 1], [2, 2, 1], [0, 2, 1]])
    hits = Naive(scene).nearest(Rays([[0.5, 1.5, 0], [0.5, 1.5, 3]], [[0, 0, 1], [0, 0, -4]]))
    assert hits.patch.tolist() == [0, 0]
    assert hits.t.tolist() == [1, 0.5]
    np.testing.assert_allclose(np.stack([hits.u, hits.v]), [[0.25, 0.25], [0.75, 0.75]], rtol=0, atol=1e-15)


def test_ray_that_points_away_or_beside_misses():
    scene = one_patch([[0, 0, 1], [2, 0, 1], [2, 2, 1], [0, 2, 1]])
    hits = Naive(scene).nearest(Rays([[1, 1, 0], [3, 1, 0], [1, 1, 1]], [[0, 0, -1], [0, 0, 1], [1, 0, 0]]))
    assert hits.patch.tolist() == [-1, -1, -1]
    assert np.isinf(hits.t).all()


def test_a_ray_never_hits_the_surface_it_starts_on():
    scene = one_patch([[0, 0, 1], [2, 0, 1], [2, 2, 1], [0, 2, 1]])
    hits = Naive(scene).nearest(Rays([[1, 1, 0]], [[0, 0, 1]], source=[0]))
    assert hits.patch.tolist() == [-1]


def test_a_hit_at_or_beyond_tmax_does_not_count():
    scene = one_patch([[0, 0, 1], [2, 0, 1], [2, 2, 1], [0, 2, 1]])
    hits = Naive(scene).nearest(Rays([[1, 1, 0]] * 2, [[0, 0, 1]] * 2, tmax=[1.0, np.nextafter(1.0, 2)]))
    assert hits.patch.tolist() == [-1, 0]


@pytest.mark.parametrize("seed", range(4))
def test_uv_and_t_name_the_same_point_of_the_patch(seed):
    scene = soup(seed)
    rays = random_rays(scene, seed, 4000)
    hits = Naive(scene).nearest(rays)
    met = np.flatnonzero(hits.patch >= 0)
    corner, u, v = scene.vertices[hits.patch[met]], hits.u[met, None], hits.v[met, None]
    point = (1 - v) * ((1 - u) * corner[:, 0] + u * corner[:, 1]) + v * ((1 - u) * corner[:, 3] + u * corner[:, 2])
    expected = rays.origin[met] + hits.t[met, None] * rays.direction[met]
    assert len(met) > 500
    np.testing.assert_allclose(point, expected, rtol=0, atol=1e-9)


def test_uv_of_a_general_quadrilateral_is_bilinear():
    corner = np.array([[0, 0, 0], [3, 0.5, 0], [2.5, 2, 0], [-0.5, 1, 0]])
    u, v = (grid.ravel() for grid in np.meshgrid(np.linspace(0.01, 0.99, 30), np.linspace(0.01, 0.99, 30)))
    point = ((1 - v) * (1 - u))[:, None] * corner[0] + ((1 - v) * u)[:, None] * corner[1] \
        + (v * u)[:, None] * corner[2] + (v * (1 - u))[:, None] * corner[3]
    eye = np.array([0.3, 0.2, 5.0])
    hits = Naive(one_patch(corner)).nearest(Rays(np.broadcast_to(eye, point.shape), point - eye))
    np.testing.assert_allclose(hits.u, u, rtol=0, atol=1e-12)
    np.testing.assert_allclose(hits.v, v, rtol=0, atol=1e-12)


@pytest.mark.parametrize("name", ["box", "box of triangles", "icosphere"])
def test_watertight_mesh_loses_no_ray_aimed_at_random_at_vertices_and_at_edges(name):
    scene = closed_mesh(name)
    random = np.random.default_rng(7)
    corners = scene.vertices
    share = random.random((3, len(corners), 4, 1))
    edges = corners + share * (np.roll(corners, -1, axis=1) - corners)
    inside = random.uniform(-0.2, 0.2, (400, 3))
    targets = np.concatenate([corners.reshape(-1, 3), edges.reshape(-1, 3)[::5], random.normal(size=(1000, 3))])
    origin = inside[random.integers(len(inside), size=len(targets))]
    origin[::7] = 0
    hits = Naive(scene).nearest(Rays(origin, targets - origin))
    assert (hits.patch >= 0).all()


@pytest.mark.parametrize(("field", "value", "message"), [
    ("origin", [[0, 0, np.nan]], "rays: Origin of ray 0 must be finite"),
    ("direction", [[0, 0, np.inf]], "rays: Direction of ray 0 must be finite"),
    ("direction", [[0, 0, 0]], "rays: Direction of ray 0 must not be zero"),
    ("direction", [[0, 0]], r"rays: Direction must be R x 3, not \(1, 2\)"),
    ("direction", [[0, 0, 1]] * 2, "rays: Direction must have as many rows as origin, not 2 for 1"),
    ("tmax", [np.nan], "rays: Tmax must be at least 0 and not NaN"),
    ("source", [0, 1], "rays: Source must have one entry for each of 1 rays"),
])
def test_rays_wrong(field, value, message):
    from golden.base.errors import InputError

    arguments = {"origin": [[0, 0, 0]], "direction": [[0, 0, 1]]} | {field: value}
    with pytest.raises(InputError, match=message):
        Rays(**arguments)
