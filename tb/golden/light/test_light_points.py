"""Points on lights, and the solid angles that they stand for."""

import numpy as np
import pytest

from golden.light.light_points import by_area
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
