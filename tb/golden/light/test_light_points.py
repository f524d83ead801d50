"""Points on lights, and the solid angles that they stand for."""

import numpy as np
import pytest

from golden.light.light_points import by_area, net, net_points
from golden.light.solid_angle import solid_angle

CORNERS = {
    "square": [(0, 0, 3), (1, 0, 3), (1, 1, 3), (0, 1, 3)],
    "trapezoid": [(0, 0, 3), (2, 0, 3), (1.5, 1, 3), (0.2, 1, 3)],
    "leaning": [(0, 0, 2), (1, 0, 3), (1, 1, 3), (0, 1, 2)],
    "triangle": [(0, 0, 2), (1, 0.2, 3), (0.3, 1, 2.5), (0.3, 1, 2.5)]}


def drawn(corners, origin, u, v):
    """Points of one light among two, and the solid angle per unit square."""
    corners = np.array([np.full((4, 3), 7.0), corners])
    toward, measure = np.empty((len(u), 3)), np.empty(len(u))
    by_area(corners, (corners[:, 2] == corners[:, 3]).all(axis=1), np.full(len(u), 1), np.tile(origin, (len(u), 1)),
            u, v, toward, measure)
    return toward, measure


@pytest.mark.parametrize("name", CORNERS)
def test_the_mean_measure_is_the_solid_angle(name):
    corners, origin = np.array(CORNERS[name], dtype=float), np.array((0.5, -0.3, 0.25))
    u, v = (axis.ravel() for axis in np.meshgrid(*[(np.arange(200) + 0.5) / 200] * 2))
    _, measure = drawn(corners, origin, u, v)
    halves = (corners - origin)[[[0, 1, 2], [0, 2, 3]]]
    assert measure.mean() == pytest.approx(solid_angle(halves).sum(), rel=2e-5)


@pytest.mark.parametrize("name", CORNERS)
def test_corners_of_the_square_are_the_light_s(name):
    corners, origin = np.array(CORNERS[name], dtype=float), np.array((5.0, 4.0, -1.0))
    toward, _ = drawn(corners, origin, np.array((0.0, 1, 1, 0)), np.array((0.0, 0, 1, 1)))
    np.testing.assert_allclose(toward + origin, corners, atol=1e-12)


def test_points_of_a_triangle_are_uniform_over_its_area():
    """A quarter of them lies in the half-size triangle at the repeated corner."""
    u, v = (axis.ravel() for axis in np.meshgrid(*[(np.arange(400) + 0.5) / 400] * 2))
    toward, _ = drawn([(0, 0, 1), (1, 0, 1), (0, 1, 1), (0, 1, 1)], np.zeros(3), u, v)
    assert (toward[:, 1] > 0.5).mean() == pytest.approx(0.25, abs=0.002)
    assert toward[:, 0].mean() == pytest.approx(1 / 3, abs=0.002)


@pytest.mark.parametrize("bits", [1, 2, 4])
def test_a_net_has_one_point_in_each_square_and_in_each_strip(bits):
    side, count = 1 << bits, 4**bits
    u, v = (axis.ravel() for axis in np.meshgrid(*[(np.arange(side) + 0.25) / side] * 2, indexing="ij"))
    number, x, y = net(u, v, bits)
    np.testing.assert_array_equal(number, np.arange(count))
    for drawn, given in ((x, u), (y, v)):
        np.testing.assert_array_equal((drawn * side).astype(int), (given * side).astype(int))
        np.testing.assert_allclose(np.sort(drawn), (np.arange(count) + 0.5) / count, atol=1e-15)
    # Any number of the unit interval belongs to a square, 1 too, to which rounding may lead.
    assert net(np.ones(1), np.ones(1), bits)[0] == count - 1


@pytest.mark.parametrize("name", CORNERS)
def test_points_of_a_net_are_those_drawn_by_area(name):
    corners = np.array([CORNERS[name]] * 2, dtype=float)
    points = net_points(corners, (corners[:, 2] == corners[:, 3]).all(axis=1), 2)
    u, v = (axis.ravel() for axis in np.meshgrid(*[(np.arange(4) + 0.5) / 4] * 2, indexing="ij"))
    _, x, y = net(u, v, 2)
    toward, _ = drawn(corners[0], np.zeros(3), x, y)
    np.testing.assert_allclose(points.reshape(2, 16, 3), np.stack([toward] * 2), atol=1e-12)
