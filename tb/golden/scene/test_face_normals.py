"""Normals by the order of corners, for polygons of any number of corners, and what contradicts them."""

import numpy as np
import pytest

from golden.scene.face_normals import area_vectors, contradicted

# A unit square, a triangle of half its area, and an L of three unit squares, all counter-clockwise from above.
POINTS = np.array([(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (2, 0, 0), (2, 1, 0), (1, 2, 0), (0, 2, 0)], dtype=float)
COUNTS, CORNERS = np.array([4, 3, 6]), np.array([0, 1, 2, 3, 0, 1, 2, 0, 4, 5, 2, 6, 7])
UP = np.tile((0.0, 0, 1), (len(CORNERS), 1))


def test_area_vectors_have_twice_the_areas_and_point_to_the_front():
    np.testing.assert_array_equal(area_vectors(POINTS, COUNTS, CORNERS), [(0, 0, 2), (0, 0, 1), (0, 0, 6)])
    turned = np.concatenate([part[::-1] for part in np.split(CORNERS, [4, 7])])
    np.testing.assert_array_equal(area_vectors(POINTS, COUNTS, turned), [(0, 0, -2), (0, 0, -1), (0, 0, -6)])


@pytest.mark.parametrize(("normals", "count"), [
    (UP, 0), (-UP, 3), (UP * np.repeat([1, -1, 1], COUNTS)[:, None], 1), (0 * UP, 0), (np.nan * UP, 0),
    (np.tile((1.0, 0, 0), (len(CORNERS), 1)), 0)])
def test_faces_are_contradicted_by_the_sum_of_their_normals(normals, count):
    assert contradicted(POINTS, COUNTS, CORNERS, normals) == count


@pytest.mark.parametrize(("counts", "corners"), [([], []), ([3, 0], [0, 1, 2]), ([3], [0, 1, 8]), ([3], [0, 1, -1])])
def test_what_is_no_mesh_is_left_to_its_check(counts, corners):
    counts, corners = np.array(counts, dtype=int), np.array(corners, dtype=int)
    assert contradicted(POINTS, counts, corners, np.ones((len(corners), 3))) == 0
