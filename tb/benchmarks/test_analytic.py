import numpy as np
import pytest

from benchmarks.analytic import point_to_polygon, polygon_to_polygon
from benchmarks.closed_forms import b_4, b_5, c_11, c_14, c_41
from golden.base.errors import InputError
from tb.golden.light.cube import FACES, cube


def rectangle(x, y, z=0.0):
    """In the plane of height z, its front up."""
    return np.array([(0, 0, z), (x, 0, z), (x, y, z), (0, y, z)], dtype=float)


def wall(y, height):
    """On the plane x = 0 over the edge 0..y of the floor, its front towards +x."""
    return np.array([(0, 0, 0), (0, y, 0), (0, y, height), (0, 0, height)], dtype=float)


def equal_area_disc(sides, z=0.0):
    """Regular polygon of area pi, its front up."""
    angle = 2 * np.pi * np.arange(sides) / sides
    radius = np.sqrt(2 * np.pi / sides / np.sin(2 * np.pi / sides))
    return np.stack([radius * np.cos(angle), radius * np.sin(angle), np.full(sides, z)], axis=1)


def rotation(seed):
    q, r = np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))
    q *= np.sign(np.diag(r))
    return q if np.linalg.det(q) > 0 else -q


def test_catalogue_forms_give_the_published_values():
    np.testing.assert_allclose(
        [c_11(1, 1), c_14(1, 1), b_4(1, 1), b_4(2, 1), b_5(1, 1, 1), b_5(1, 1, 0.5), c_41(1, 1)],
        [0.199824896, 0.200043776, 0.138531606, 0.167375010, 0.055734197, 0.124268910, 0.381966011], rtol=0, atol=6e-10)


@pytest.mark.parametrize(("x", "y"), [(1, 1), (2, 0.5), (10, 10), (0.1, 0.3)])
def test_opposed_rectangles_c11(x, y):
    factor = polygon_to_polygon(rectangle(x, y), rectangle(x, y, 1.0)[::-1])
    assert factor == pytest.approx(c_11(x, y), rel=0, abs=1e-8)


@pytest.mark.parametrize(("w", "h"), [(1, 1), (1, 2), (2, 1), (0.05, 3), (5, 0.1)])
def test_rectangles_with_a_common_edge_c14(w, h):
    factor = polygon_to_polygon(rectangle(w, 1), wall(1, h))
    assert factor == pytest.approx(c_14(w, h), rel=0, abs=1e-8)


@pytest.mark.parametrize(("a", "b"), [(1, 1), (2, 1), (0.5, 0.5), (100, 0.01)])
def test_element_to_parallel_rectangle_b4(a, b):
    factor = point_to_polygon([(0, 0, 0)], [(0, 0, 1)], [rectangle(a, b, 1.0)[::-1]])
    np.testing.assert_allclose(factor, [[b_4(a, b)]], rtol=0, atol=1e-13)


@pytest.mark.parametrize(("a", "b", "c"), [(1, 1, 1), (2, 1, 1), (1, 1, 0.5)])
def test_element_to_perpendicular_rectangle_b5(a, b, c):
    factor = point_to_polygon([(c, 0, 0)], [(0, 0, 1)], [wall(b, a)])
    np.testing.assert_allclose(factor, [[b_5(a, b, c)]], rtol=0, atol=1e-13)


@pytest.mark.parametrize("sides", [24, 64])
def test_coaxial_discs_c41_within_the_polygons_own_bound(sides):
    # Area times form factor grows with either disc, and the polygon lies between its inner and its outer circle.
    outer = np.sqrt(2 * np.pi / sides / np.sin(2 * np.pi / sides))
    inner = outer * np.cos(np.pi / sides)
    factor = polygon_to_polygon(equal_area_disc(sides), equal_area_disc(sides, 1.0)[::-1], tolerance=1e-8)
    assert inner**2 * c_41(inner, inner) < factor < outer**2 * c_41(outer, outer)
    # The polygon's border leaves the disc's by a mean of zero, so only the square of that, 1/sides^4, shows.
    assert factor == pytest.approx(c_41(1, 1), rel=0, abs=2 / sides**4)


def test_form_factors_of_the_cube_close():
    faces = cube(1).vertices
    factors = [polygon_to_polygon(faces[0], face) for face in faces[1:]]
    assert sum(factors) == pytest.approx(1, rel=0, abs=1e-8)
    assert len(factors) == len(FACES) - 1


def test_a_closed_room_is_seen_whole_from_any_element_in_any_attitude():
    generator = np.random.default_rng(5)
    turn = rotation(5)
    faces = cube(3).vertices @ turn
    points = generator.uniform(0.01, 0.99, size=(200, 3)) @ turn
    normals = generator.normal(size=(200, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    seen = point_to_polygon(points, normals, faces)
    assert seen.min() >= 0
    np.testing.assert_allclose(seen.sum(axis=1), 1, rtol=0, atol=1e-12)


@pytest.mark.parametrize("turn", [np.eye(3), rotation(7), rotation(8)], ids=["straight", "turned", "turned too"])
def test_elements_on_the_walls_see_all_but_their_own_plane(turn):
    scene = cube(4)
    points = scene.vertices.mean(axis=1) @ turn
    seen = point_to_polygon(points, scene.normals @ turn, scene.vertices @ turn)
    face = np.arange(len(scene)) // 16
    assert (seen[face[:, None] == face] == 0).all()
    np.testing.assert_allclose(seen.sum(axis=1), 1, rtol=0, atol=1e-12)


def test_reciprocity_of_random_triangles_and_quads():
    generator = np.random.default_rng(6)
    for seed in range(6):
        first = np.append(generator.uniform(0, 1, size=(3, 2)), np.zeros((3, 1)), axis=1) @ rotation(seed)
        second = rectangle(*generator.uniform(0.2, 2, size=2)) @ rotation(seed + 100) + generator.uniform(0.5, 1, 3)
        area_1 = np.linalg.norm(np.cross(first[1] - first[0], first[2] - first[0])) / 2
        area_2 = np.linalg.norm(np.cross(second[1] - second[0], second[2] - second[0]))
        sides = [(a, b) for a in (first, first[::-1]) for b in (second, second[::-1])]
        there = np.array([area_1 * polygon_to_polygon(a, b) for a, b in sides])
        back = np.array([area_2 * polygon_to_polygon(b, a) for a, b in sides])
        np.testing.assert_allclose(there, back, rtol=0, atol=1e-8)
        assert there.max() > 1e-6


def test_the_back_of_a_polygon_counts_negative():
    front = point_to_polygon([(0.3, 0.3, 0)], [(0, 0, 1)], [rectangle(1, 1, 1.0)[::-1]])
    back = point_to_polygon([(0.3, 0.3, 0)], [(0, 0, 1)], [rectangle(1, 1, 1.0)])
    np.testing.assert_allclose(back, -front, rtol=0, atol=1e-15)
    assert polygon_to_polygon(rectangle(1, 1), rectangle(1, 1, 1.0)) == 0.0


def test_a_polygon_through_the_horizon_counts_for_its_upper_part():
    whole = np.array([(1, -1, -3), (1, 1, -3), (1, 1, 2), (1, -1, 2)], dtype=float)[::-1]
    upper = np.array([(1, -1, 0), (1, 1, 0), (1, 1, 2), (1, -1, 2)], dtype=float)[::-1]
    seen = point_to_polygon([(0, 0, 0)], [(0, 0, 1)], [whole, upper])
    assert seen[0, 0] == pytest.approx(seen[0, 1], rel=0, abs=1e-15)
    assert seen[0, 0] == pytest.approx(2 * b_5(2, 1, 1), rel=0, abs=1e-14)


@pytest.mark.parametrize("point", [(0, 0, 0), (0.5, 0, 0), (1e-9, 0.5, 0), (0, 0.5, 0.5), (0.5, 0.5, 1e-15)])
def test_elements_at_corners_and_edges_and_on_the_polygon_stay_between_zero_and_one(point):
    seen = point_to_polygon([point], [(0, 0, 1)], [rectangle(1, 1), wall(1, 1), wall(1, 1)[::-1]])
    assert np.isfinite(seen).all()
    assert np.abs(seen).max() <= 1 + 1e-12


def test_slivers_and_repeated_vertices_cost_nothing():
    quad = rectangle(1, 1, 1.0)[::-1]
    triangle = quad[[0, 1, 2, 2]]
    sliver = np.array([(0, 0, 1), (1e-12, 0, 1), (1e-12, 1, 1)], dtype=float)[::-1]
    seen = point_to_polygon([(0.2, 0.1, 0)], [(0, 0, 1)], [triangle, quad[[0, 2, 3, 3]]])
    np.testing.assert_allclose(seen.sum(), point_to_polygon([(0.2, 0.1, 0)], [(0, 0, 1)], [quad]), rtol=0, atol=1e-14)
    assert 0 <= point_to_polygon([(0.2, 0.1, 0)], [(0, 0, 1)], [sliver])[0, 0] < 1e-12


@pytest.mark.parametrize(("source", "target", "tolerance", "message"), [
    (rectangle(1, 1)[:2], rectangle(1, 1), 1e-9, "Source must have at least three vertices"),
    (rectangle(1, 1), rectangle(0, 1), 1e-9, "Target must have an area"),
    (rectangle(1, 1), rectangle(1, np.nan), 1e-9, "Target must be finite"),
    (rectangle(1, 1), rectangle(1, 1)[:, :2], 1e-9, "Target must be any x 3"),
    (rectangle(1, 1), rectangle(1, 1), 0.0, "Tolerance must be 1e-12 to 1"),
])
def test_unusable_polygons_are_refused(source, target, tolerance, message):
    with pytest.raises(InputError, match=message):
        polygon_to_polygon(source, target, tolerance=tolerance)


def test_points_without_normals_are_refused():
    with pytest.raises(InputError, match="Normals must be 2 x 3"):
        point_to_polygon([(0, 0, 0), (1, 0, 0)], [(0, 0, 1)], [rectangle(1, 1)])
