import numpy as np
import pytest

from golden.light.solid_angle import direction_to_triangle, solid_angle

TRIANGLES = {
    "octant": np.eye(3),
    "near": np.array([(1, 0, 0.01), (-1, 1, 0.01), (-0.5, -1, 0.02)]),
    "far": np.array([(0, 0, 20), (1, 0, 20), (0, 1, 21)], dtype=float),
    "sliver": np.array([(-1, 0.3, 1), (1, 0.3, 1), (0.5, 0.31, 1)]),
    "turned": np.array([(1, 2, 0), (0, 2, 1), (2, 2, 1)], dtype=float)[::-1],
}


@pytest.fixture(params=TRIANGLES)
def triangle(request):
    return TRIANGLES[request.param]


def split(triangle):
    """Three triangles around a point inside."""
    middle = np.array([0.5, 0.3, 0.2]) @ triangle
    return np.array([[middle, triangle[k], triangle[k - 2]] for k in range(3)])


def test_known_solid_angles():
    np.testing.assert_allclose(solid_angle(np.eye(3)[None]), np.pi / 2, rtol=1e-14)
    face = np.array([(1, -1, -1), (1, 1, -1), (1, 1, 1), (1, -1, 1)], dtype=float)
    np.testing.assert_allclose(solid_angle(face[[[0, 1, 2], [0, 2, 3]]]).sum(), 4 * np.pi / 6, rtol=1e-14)
    small = 1e-6 * np.array([(0, 0, 1e6), (1, 0, 1e6), (0, 1, 1e6)])
    np.testing.assert_allclose(solid_angle(small[None]), 0.5e-12, rtol=1e-6)


@pytest.mark.parametrize("height", [2.0, 0.5, 1e-3, 1e-9, 0.0])
@pytest.mark.parametrize("turns", [(0, 120, 240), (0, 90, 180), (0, 179, 181), (10, 100, 350)])
def test_up_to_a_hemisphere_a_solid_angle_is_the_excess_of_the_angles(height, turns):
    """Girard's theorem; in the plane of the origin the triangle covers a half space, or nothing if it is beside it."""
    turns = np.radians(turns)
    corners = np.stack([np.cos(turns), np.sin(turns), np.full(3, height)], axis=1)
    excess = -np.pi
    for a, b, c in (corners, corners[[1, 2, 0]], corners[[2, 0, 1]]):
        one, other = np.cross(a, b), np.cross(a, c)
        excess += np.arctan2(np.linalg.norm(np.cross(one, other)), one @ other)
    np.testing.assert_allclose(solid_angle(corners[None])[0], excess, rtol=1e-6, atol=1e-7)


def test_solid_angles_add_up_and_do_not_depend_on_length_or_turn(triangle):
    whole = solid_angle(triangle[None])[0]
    assert solid_angle(split(triangle)).sum() == pytest.approx(whole, rel=1e-9)
    assert solid_angle(triangle[None, ::-1] * [[0.1], [3], [7]])[0] == pytest.approx(whole, rel=1e-9)
    assert solid_angle(np.zeros((1, 3, 3)))[0] == 0


def test_directions_are_unit_vectors_into_the_triangle(triangle):
    x, y = np.random.default_rng(1).random((2, 1000))
    x[:4], y[:4] = (0, 1, 0, 1), (0, 0, 1, 1)
    direction = direction_to_triangle(np.tile(triangle, (1000, 1, 1)), x, y)
    np.testing.assert_allclose(np.linalg.norm(direction, axis=1), 1, rtol=1e-12)
    share = direction @ np.linalg.inv(triangle)
    assert share.min() > -1e-9 * np.abs(share).max()


def test_directions_are_spread_evenly(triangle):
    """Each of three parts gets its share of them."""
    count = 40000
    x, y = np.random.default_rng(2).random((2, count))
    direction = direction_to_triangle(np.tile(triangle, (count, 1, 1)), x, y)
    for part in split(triangle):
        expected = solid_angle(part[None])[0] / solid_angle(triangle[None])[0]
        inside = (direction @ np.linalg.inv(part)).min(axis=1) > 0
        assert inside.mean() == pytest.approx(expected, abs=4 * np.sqrt(expected / count))
