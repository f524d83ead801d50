from itertools import combinations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from golden.base.errors import InputError
from golden.scene.adjacency import inside_out, patch_normals, shared_edges, smooth_numbers, surface_numbers
from golden.scene.polygons import (
    as_patches,
    crosses_itself,
    cut_polygon,
    is_convex_quad,
    merge_triangles,
    split_nonplanar,
)
from tb.lib.schedules import SETTINGS


def rotation(seed):
    return np.linalg.qr(np.random.default_rng(seed).normal(size=(3, 3)))[0]


def polygon_vector(points):
    local = points - points[0]
    return 0.5 * np.cross(local, np.roll(local, -1, axis=0)).sum(axis=0)


def star(seed, count, *, spread):
    """A star-shaped simple polygon somewhere in space."""
    random = np.random.default_rng(seed)
    angle = (np.arange(count) + 0.8 * random.random(count)) * 2 * np.pi / count
    radius = 1 + spread * (random.random(count) - 0.5)
    plane = np.stack((radius * np.cos(angle), radius * np.sin(angle), np.zeros(count)), axis=1)
    return plane @ rotation(seed).T + 3 * random.normal(size=3)


def check_cut(points):
    patches = cut_polygon(points)
    vector = polygon_vector(points)
    normals, areas = patch_normals(patches)
    assert areas.sum() == pytest.approx(np.linalg.norm(vector), rel=1e-9)
    assert (normals @ vector > 0).all()
    is_quad = (patches[:, 3] != patches[:, 2]).any(axis=1)
    assert is_convex_quad(patches[is_quad]).all()
    corners = {tuple(point) for point in patches.reshape(-1, 3)}
    assert corners == {tuple(point) for point in points}
    return patches


def grid(columns, rows, *, matrix=None, shear=0.0):
    x, y = np.meshgrid(np.arange(columns + 1.0), np.arange(rows + 1.0), indexing="ij")
    points = np.stack((x + shear * y, 0.7 * y, 0 * x), axis=-1) @ (np.eye(3) if matrix is None else matrix).T
    return np.stack((points[:-1, :-1], points[1:, :-1], points[1:, 1:], points[:-1, 1:]), axis=2).reshape(-1, 4, 3)


def triangles(quads):
    return quads[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)


def as_sets(patches):
    return {frozenset(map(tuple, patch)) for patch in patches}


@settings(SETTINGS, max_examples=150)
@given(seed=st.integers(0, 10 ** 6), count=st.integers(3, 40), spread=st.floats(0, 1.6))
def test_a_cut_polygon_keeps_its_area_sides_and_vertices_in_convex_pieces(seed, count, spread):
    check_cut(star(seed, count, spread=spread))


@pytest.mark.parametrize("count", [3, 4, 5, 6, 7, 8, 100])
def test_a_convex_polygon_becomes_as_few_quads_as_there_can_be(count):
    assert len(check_cut(star(count, count, spread=0.0))) == (count - 1) // 2


def test_vertices_on_straight_sides_stay_corners_for_the_neighbours():
    points = np.array([(0, 0, 0), (0.5, 0, 0), (1, 0, 0), (1, 1 / 3, 0), (1, 2 / 3, 0), (1, 1, 0), (0, 1, 0)])
    check_cut(points @ rotation(3).T)


def test_repeated_vertices_are_dropped():
    square = np.array([(0, 0, 0), (1, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0), (0, 0, 0)], dtype=float)
    assert as_sets(cut_polygon(square)) == as_sets(square[None])


def test_a_hole_joined_by_a_bridge_stays_open():
    outline = [(0, 0), (3, 0), (3, 3), (0, 3), (0, 0), (1, 1), (1, 2), (2, 2), (2, 1), (1, 1)]
    patches = cut_polygon(np.array([(x, y, 0) for x, y in outline], dtype=float))
    assert patch_normals(patches)[1].sum() == pytest.approx(8)


@pytest.mark.parametrize(("points", "message"), [
    ([(0, 0, 0), (1, 1, 0), (1, 0, 0), (0, 1.5, 0)], "polygon: it crosses itself"),
    ([(0, 0, 0), (1, 1, 1), (2, 2, 2), (3, 3, 3)], "polygon: it has no area"),
    ([(0, 0, 0), (1, 0, 0), (0, 0, 0)], "polygon: it has 2 different vertices, three at least are needed"),
])
def test_a_polygon_that_is_none_is_refused(points, message):
    with pytest.raises(InputError) as error:
        cut_polygon(points)
    assert str(error.value) == message


@pytest.mark.parametrize("order", ["in turn", "halves apart", "shuffled", "turned corners"])
@pytest.mark.parametrize("shear", [0.0, 0.4])
def test_a_grid_comes_back_whole_from_its_triangles(order, shear):
    quads = grid(13, 9, matrix=rotation(7), shear=shear).astype(np.float32).astype(np.float64)
    cut = triangles(quads)
    random = np.random.default_rng(5)
    if order == "halves apart":
        cut = np.concatenate((cut[::2], cut[1::2]))
    elif order == "shuffled":
        cut = random.permutation(cut)
    elif order == "turned corners":
        cut = np.stack([np.roll(triangle, turn, axis=0) for triangle, turn in
                        zip(cut, random.integers(0, 3, len(cut)), strict=True)])
    patches, surface, parent = merge_triangles(cut, np.zeros(len(cut)))
    assert as_sets(patches) == as_sets(quads)
    assert len(set(surface)) == 1
    assert len(parent) == len(quads)


def test_merged_quads_keep_the_side_of_their_triangles():
    cut = triangles(grid(4, 4, matrix=rotation(2)))
    patches, _, parent = merge_triangles(cut, np.zeros(len(cut)))
    assert np.allclose(patch_normals(patches)[0], patch_normals(as_patches(cut[parent]))[0])


def test_triangles_of_two_groups_or_two_planes_do_not_merge():
    cut = triangles(grid(1, 1))
    assert len(merge_triangles(cut, np.array([0, 1]))[0]) == 2
    cut[1, 2, 2] += 0.01
    assert len(merge_triangles(cut, np.zeros(2))[0]) == 2


def test_a_pair_that_is_no_strictly_convex_quad_does_not_merge():
    straight = np.array([[(0, 0, 0), (1, 0, 0), (0, 1, 0)], [(1, 0, 0), (2, 0, 0), (0, 1, 0)]], dtype=float)
    patches, surface, _ = merge_triangles(straight, np.zeros(2))
    assert len(patches) == 2
    assert len(set(surface)) == 1


@pytest.mark.parametrize("offset", [0.0, 1.0, 100.0])
def test_float32_rounding_leaves_a_planar_quad_whole(offset):
    quads = (grid(20, 20, matrix=rotation(11)) + offset).astype(np.float32).astype(np.float64)
    assert len(split_nonplanar(quads)[0]) == len(quads)


def test_a_quad_out_of_its_plane_becomes_two_triangles_over_the_shorter_diagonal():
    quads = np.array([[(0, 0, 0), (2, 0, 0), (3, 1, 0.2), (0, 1, 0)], [(5, 0, 0), (6, 0, 0), (6, 1, 0), (5, 1, 0)]])
    patches, parent = split_nonplanar(quads)
    assert parent.tolist() == [0, 0, 1]
    assert as_sets(patches[:2]) == {frozenset({(0, 0, 0), (2, 0, 0), (0, 1, 0)}),
                                    frozenset({(2, 0, 0), (3, 1, 0.2), (0, 1, 0)})}


def test_a_dart_is_split_over_the_diagonal_inside_of_it_though_it_is_the_longer_one():
    dart = np.array([[(0, 0, 0), (4, 1, 0), (0.9, 1, 0), (1, 5, 0)]], dtype=float)
    patches, _ = split_nonplanar(dart)
    assert patch_normals(patches)[1].sum() == pytest.approx(patch_normals(dart)[1][0])
    assert (patch_normals(patches)[0][:, 2] > 0).all()


@pytest.mark.parametrize("digits", [None, 6, 5])
@pytest.mark.parametrize("turn", range(4))
def test_a_quad_with_a_straight_corner_is_not_cut_into_a_sliver_at_it(digits, turn):
    """The corner stands anywhere on its side, but for the rounding of its coordinates."""
    random = np.random.default_rng(turn)
    quads = np.zeros((3000, 4, 3))
    quads[:, 1, 0], quads[:, 2, 0] = random.uniform(0.05, 0.95, 3000), 1
    quads[:, 3, :2] = random.uniform((-1, 0.3), (2, 3), (3000, 2))
    quads = np.roll(quads @ rotation(turn).T + random.normal(size=(3000, 1, 3)), turn, axis=1)
    patches, parent = split_nonplanar(quads if digits is None else quads.round(digits))
    areas = patch_normals(patches)[1]
    assert (areas > 1e-3 * np.bincount(parent, areas)[parent]).all()


@settings(SETTINGS, max_examples=300)
@given(corners=st.lists(st.tuples(st.integers(0, 6), st.integers(0, 6)), min_size=4, max_size=4, unique=True),
       seed=st.integers(0, 99))
def test_a_quad_crosses_itself_if_two_of_its_sides_do(corners, seed):
    def side(one, other, point):
        return np.sign((other[0] - one[0]) * (point[1] - one[1]) - (other[1] - one[1]) * (point[0] - one[0]))

    a, b, c, d = corners
    expected = any(side(p, q, r) * side(p, q, s) == side(r, s, p) * side(r, s, q) == -1
                   for p, q, r, s in ((a, b, c, d), (b, c, d, a)))
    quads = np.array([[(*corner, 0) for corner in corners]], dtype=float) @ rotation(seed).T
    assert crosses_itself(quads).tolist() == [expected]


def test_triangles_pass_the_split_unchanged():
    patches = as_patches(triangles(grid(2, 2)))
    assert np.array_equal(split_nonplanar(patches)[0], patches)


def box():
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    faces = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    return corners[np.array(faces)]


@settings(SETTINGS, max_examples=80)
@given(st.lists(st.tuples(st.permutations(range(5)), st.integers(3, 4), st.integers(0, 1)), min_size=1, max_size=7))
def test_every_pair_of_a_group_with_an_edge_in_opposite_directions_is_found(given):
    """Among few points, so that an edge may belong to any number of patches."""
    points = np.random.default_rng(3).normal(size=(5, 3))
    corners = [order[:count] for order, count, _ in given]
    patches = np.array([points[[*own, own[-1]][:4]] for own in corners])
    groups = np.array([group for *_, group in given])
    expected = [(left, corners[left].index(start), right, corners[right].index(end))
                for left, right in combinations(range(len(given)), 2) if groups[left] == groups[right]
                for start, end in edges_of(corners[left]) if (end, start) in edges_of(corners[right])]
    found = shared_edges(patches, groups)
    # The edge from a triangle's repeated corner to its first one is the fourth.
    numbers = [(edge if len(corners[patch]) == 4 or edge < 2 else 3) for patch, edge in
               ((one[side], one[side + 1]) for one in expected for side in (0, 2))]
    assert sorted(zip(found.left.tolist(), found.left_edge.tolist(), found.right.tolist(), found.right_edge.tolist(),
                      strict=True)) == sorted(
        (left, first, right, second) for (left, _, right, _), first, second in
        zip(expected, numbers[0::2], numbers[1::2], strict=True))


def test_a_patch_folded_back_onto_its_neighbour_is_another_surface():
    """They share an edge in opposite directions and lie in one plane, and one is the other's mirror image."""
    first = as_patches(np.array([[(0, 0, 0), (1, 0, 0), (0, 1, 0)]], dtype=float))
    beside, folded = (as_patches(np.array([[(1, 0, 0), (0, 0, 0), (0.2, y, 0)]])) for y in (-1, 1))
    for other, alone in ((beside, False), (folded, True)):
        surface = surface_numbers(np.concatenate([first, other]), np.zeros(2))
        assert (surface[0] != surface[1]) == alone
        smooth = smooth_numbers(np.concatenate([first, other]), np.zeros(2), crease=30)
        assert (smooth[0] != smooth[1]) == alone


def edges_of(corners):
    return set(zip(corners, [*corners[1:], corners[0]], strict=True))


def test_only_a_closed_body_whose_fronts_look_inwards_is_inside_out():
    outwards, inwards = box() + 5, box()[:, ::-1] - 5
    patches = np.concatenate((outwards, inwards, inwards[:5] + 20))
    assert inside_out(patches, np.zeros(17)).tolist() == [False] * 6 + [True] * 6 + [False] * 5


def test_the_narrow_facets_of_a_long_thin_rod_are_not_one_surface():
    angle = np.linspace(0, 2 * np.pi, 65)[:-1]
    ring = 0.01 * np.stack((np.cos(angle), np.sin(angle)), axis=1)
    low, high = (np.column_stack((ring, np.full(64, z))).astype(np.float32).astype(float) for z in (0.0, 10.0))
    side = np.stack((low, np.roll(low, -1, 0), np.roll(high, -1, 0), high), axis=1)
    assert len(set(surface_numbers(side, np.zeros(64)))) == 64
