import numpy as np

from golden.light.factors.sides import Sides
from tb.golden.light.scenes import BLACK, rectangle, scene_of

TRIANGLE = np.array([(0, 0, 2), (1, 0, 2), (0, 1, 2), (0, 1, 2)], dtype=float)


def two_sided():
    return Sides(scene_of(([rectangle((0, 0, 0), (1, 0, 0), (0, 2, 0))], BLACK),
                          ([rectangle((0, 0, 1), (2, 0, 0), (0, 2, 0)), TRIANGLE], BLACK, {"two_sided": True})))


def test_backs_of_two_sided_patches_follow_the_fronts():
    sides = two_sided()
    assert len(sides) == 5
    np.testing.assert_array_equal(sides.patch, [0, 1, 2, 1, 2])
    np.testing.assert_array_equal(sides.front, [True, True, True, False, False])
    np.testing.assert_allclose(sides.area, [2, 4, 0.5, 4, 0.5])
    np.testing.assert_array_equal(sides.normal[:, 2], [1, 1, 1, -1, -1])


def test_vertices_run_counter_clockwise_seen_from_the_side():
    sides = two_sided()
    v = sides.vertices
    vectors = np.cross(v[:, 2] - v[:, 0], v[:, 3] - v[:, 1]) / 2
    np.testing.assert_allclose(vectors, sides.normal * sides.area[:, None])
    np.testing.assert_array_equal(v[sides.triangle, 2], v[sides.triangle, 3])


def test_balls_contain_their_patches():
    sides = two_sided()
    distance = np.linalg.norm(sides.vertices - sides.centre[:, None], axis=2)
    np.testing.assert_array_equal(distance.max(axis=1), sides.radius)


def test_rays_meet_the_side_that_faces_them():
    sides = two_sided()
    down, up = (0, 0, -1), (0, 0, 1)
    met = sides.met(np.array([0, 0, 1, 1, 2]), np.array([down, up, down, up, up], dtype=float))
    np.testing.assert_array_equal(met, [0, -1, 1, 3, 4])
