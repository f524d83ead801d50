from itertools import product

import numpy as np
import pytest

from golden.light import lattice as lattice_module
from golden.light.lattice import Lattice
from golden.light.surface_points import bilinear
from golden.scene.tessellate import sphere
from tb.golden.light.scenes import BLACK, rectangle, scene_of

SMOOTH = {"smooth": True}
FLOOR = rectangle((0, 0, 0), (2, 0, 0), (0, 1, 0))
TRAPEZOID = np.array([(-1, 0, 1), (3, 0, 1), (2, 2, 3), (0, 2, 3)], dtype=float)
TRIANGLE = np.array([(0, 0, 0), (3, 0, 1), (1, 2, 0), (1, 2, 0)], dtype=float)
BESIDE = np.array([(3, 0, 1), (4, 3, 0), (1, 2, 0), (1, 2, 0)], dtype=float)


def lattice_of(scene, cuts, patch=None, side=None):
    patch = np.arange(len(scene)) if patch is None else np.array(patch)
    return Lattice(scene, patch=patch, side=np.ones(len(patch)) if side is None else np.array(side, dtype=float),
                   cuts=np.broadcast_to(np.array(cuts), (len(patch), 2)).copy(),
                   lower=np.zeros((len(patch), 2)), upper=np.ones((len(patch), 2)))


def borders_and_inside(cuts):
    """(u, v) at random, on the borders of cells and of the patch, and a rounding beside them."""
    random = np.random.default_rng(2)
    step = np.array([k / cuts for k in range(cuts + 1)])
    near = np.clip(np.concatenate([step, np.nextafter(step, 0), np.nextafter(step, 1)]), 0, 1)
    u, v = np.meshgrid(near, near)
    return np.append(random.random(400), u.ravel()), np.append(random.random(400), v.ravel())


@pytest.fixture
def bare(monkeypatch):
    """Nodes exactly on the corners of cells."""
    monkeypatch.setattr(lattice_module, "INSET", 0.0)
    monkeypatch.setattr(lattice_module, "LIFT", 0.0)
    monkeypatch.setattr(lattice_module, "CLEAR", 0.0)


@pytest.mark.usefixtures("bare")
@pytest.mark.parametrize("patch", [FLOOR, TRAPEZOID, TRIANGLE, BESIDE])
@pytest.mark.parametrize("cuts", [1, 2, 7, 12])
def test_interpolation_reproduces_what_is_bilinear_on_a_quad_and_linear_on_a_triangle(patch, cuts):
    """Positions are such functions: interpolated from the nodes they must be the patch's own."""
    lattice = lattice_of(scene_of((patch, BLACK)), cuts)
    u, v = borders_and_inside(cuts)
    sample = lattice.at(np.zeros(len(u), dtype=int), u, v)
    found = np.einsum("kn,knx->kx", sample.weights, lattice.position[sample.nodes])
    np.testing.assert_allclose(found, bilinear(patch[None].repeat(len(u), axis=0), u, v), rtol=0, atol=1e-12)


@pytest.mark.usefixtures("bare")
def test_cuts_may_differ_along_u_and_v_and_from_sheet_to_sheet():
    scene = scene_of((FLOOR, BLACK), (TRIANGLE, BLACK), (TRAPEZOID, BLACK))
    lattice = lattice_of(scene, [(5, 2), (4, 4), (1, 6)])
    assert len(lattice) == 6 * 3 + 15 + 2 * 7
    assert lattice.cells == 10 + 16 + 6
    u, v = np.random.default_rng(3).random((2, 600))
    sheet = np.arange(600) % 3
    sample = lattice.at(sheet, u, v)
    found = np.einsum("kn,knx->kx", sample.weights, lattice.position[sample.nodes])
    np.testing.assert_allclose(found, bilinear(scene.vertices[sheet], u, v), rtol=0, atol=1e-12)
    ranges = [np.unique(sample.cell[sheet == number])[[0, -1]].tolist() for number in range(3)]
    assert ranges == [[0, 9], [10, 22], [26, 31]]


@pytest.mark.parametrize("patch", [FLOOR, TRIANGLE])
@pytest.mark.parametrize("cuts", [1, 3, 7])
def test_weights_are_shares(patch, cuts):
    lattice = lattice_of(scene_of((patch, BLACK)), cuts)
    u, v = borders_and_inside(cuts)
    sample = lattice.at(np.zeros(len(u), dtype=int), u, v)
    assert sample.weights.min() >= -1e-15
    np.testing.assert_allclose(sample.weights.sum(axis=1), 1, rtol=0, atol=1e-14)
    for within in (sample.a, sample.b):
        assert within.min() >= 0
        assert within.max() <= 1
    assert sample.nodes.min() >= 0
    assert sample.nodes.max() < len(lattice)


@pytest.mark.usefixtures("bare")
def test_a_triangles_third_edge_stays_in_its_cells():
    """u = 1 is the third edge; there rounding may put a point beyond it, on any v."""
    lattice = lattice_of(scene_of((TRIANGLE, BLACK)), 7)
    v = np.concatenate([np.linspace(0, 1, 500), 1 - 10.0 ** -np.arange(1, 17), np.nextafter([3 / 7, 1.0], 0)])
    sample = lattice.at(np.zeros(len(v), dtype=int), np.ones(len(v)), v)
    row, column = np.divmod(sample.cell, 7)
    assert (row + column <= 6).all()
    found = np.einsum("kn,knx->kx", sample.weights, lattice.position[sample.nodes])
    np.testing.assert_allclose(found, TRIANGLE[1] + v[:, None] * (TRIANGLE[2] - TRIANGLE[1]), rtol=0, atol=1e-12)


@pytest.mark.parametrize("step", [(2, 0, 0), (-2, 0, 0), (0, 1, 0), (0, -1, 0)])
@pytest.mark.parametrize("turn", [0, 2])
def test_neighbours_of_one_smooth_group_share_the_nodes_between_them(step, turn):
    cuts = 5
    patches = np.array([FLOOR, np.roll(FLOOR + step, turn, axis=0)])
    assert len(lattice_of(scene_of((patches, BLACK, SMOOTH)), cuts)) == 2 * 36 - 6
    assert len(lattice_of(scene_of((patches, BLACK)), cuts)) == 2 * 36


def test_triangles_share_nodes_with_each_other_and_with_quads():
    quad = np.array([(0, 0, 0), (-1, 2, 0), (2, 3, -1), (3, 0, 1)], dtype=float)
    quad[1:3] = quad[0] + (-1, -1, 0), quad[3] + (-1, -1, 0)
    lattice = lattice_of(scene_of((np.array([TRIANGLE, BESIDE, quad]), BLACK, SMOOTH)), 4)
    assert len(lattice) == 15 + 15 - 5 + 25 - 5


def test_round_coordinates_do_not_part_what_belongs_together():
    """0.1 in a scene of 12.8 is 7812.5 roundings: an unlucky border would separate equal corners."""
    for height in 0.1 * np.arange(1, 60):
        first = rectangle((0, 0, 0), (12.8, 0, 0), (0, height, 0))
        second = np.roll(rectangle((0, height, 0), (12.8, 0, 0), (0, height, 0)), -1, axis=0)
        lattice = lattice_of(scene_of((np.array([first, second]), BLACK, SMOOTH)), [(10, 2), (2, 10)])
        assert len(lattice) == 11 * 5, height


def test_the_two_sides_of_a_patch_share_nothing_and_look_away_from_each_other():
    lattice = lattice_of(scene_of((FLOOR, BLACK, {"two_sided": True})), 3, patch=[0, 0], side=[1, -1])
    front, back = (lattice.at(np.full(50, sheet), *np.random.default_rng(1).random((2, 50))) for sheet in (0, 1))
    assert not np.intersect1d(front.nodes, back.nodes).size
    np.testing.assert_array_equal(np.unique(lattice.normal[front.nodes.ravel()], axis=0), [(0, 0, 1)])
    np.testing.assert_array_equal(np.unique(lattice.normal[back.nodes.ravel()], axis=0), [(0, 0, -1)])


def test_nodes_of_a_flat_patch_stay_in_its_plane_and_move_a_little_inwards():
    scene = scene_of((FLOOR, BLACK))
    lattice = lattice_of(scene, 4)
    corners = lattice.at(np.zeros(4, dtype=int), np.array([0.0, 1, 1, 0]), np.array([0.0, 0, 1, 1])).nodes
    moved = lattice.position[corners[np.arange(4), [0, 1, 3, 2]]] - FLOOR
    np.testing.assert_allclose(moved, lattice_module.INSET * (FLOOR.mean(axis=0) - FLOOR), rtol=0, atol=1e-12)
    assert (lattice.source == scene.surface[0]).all()


def test_nodes_of_a_thin_strip_stand_clear_of_its_borders():
    strip = rectangle((0, 0, 0), (1, 0, 0), (0, 1e-4, 0))
    for scene in (scene_of((strip, BLACK)), scene_of((strip[[0, 1, 2, 2]], BLACK))):
        position = lattice_of(scene, 1).position
        used = position[np.unique(lattice_of(scene, 1).at(np.zeros(3, dtype=int), *np.eye(3)[:2]).nodes)]
        assert len(used) >= 3
        assert (np.minimum(used[:, 1], 1e-4 - used[:, 1]) > 1e-6).all()


def test_nodes_of_a_curved_surface_look_outwards_and_stand_free_of_every_facet():
    centre = np.array((1.0, 2.0, 3.0))
    scene = scene_of((sphere(centre, 2.0, segments=12), BLACK, SMOOTH))
    lattice = lattice_of(scene, 2)
    outwards = lattice.position - centre
    outwards /= np.linalg.norm(outwards, axis=1, keepdims=True)
    assert np.einsum("mj,mj->m", outwards, lattice.normal).min() > 0.95
    np.testing.assert_allclose(np.linalg.norm(lattice.normal, axis=1), 1, rtol=0, atol=1e-12)
    height = np.einsum("mnj,nj->mn", lattice.position[:, None] - scene.vertices[:, 0], scene.normals)
    assert height.max(axis=1).min() > 0


def test_a_surface_that_folds_back_on_itself_has_nodes_on_either_side():
    lattice = lattice_of(scene_of((np.array([FLOOR, FLOOR[::-1]]), BLACK, SMOOTH)), 2)
    for sheet, up in enumerate((1, -1)):
        nodes = lattice.at(np.full(9, sheet), np.arange(9) / 8, np.arange(9) / 8).nodes
        np.testing.assert_array_equal(lattice.normal[nodes.ravel(), 2], up)


def test_neighbours_are_the_corners_of_common_cells():
    quad = lattice_of(scene_of((FLOOR, BLACK)), 2)
    middle = quad.at(np.zeros(1, dtype=int), np.array([0.5]), np.array([0.5])).nodes[0, 0]
    corner = quad.at(np.zeros(1, dtype=int), np.zeros(1), np.zeros(1)).nodes[0, 0]
    counts = quad.neighbours.toarray()
    np.testing.assert_array_equal(counts, counts.T)
    assert np.sort(counts[middle]).tolist() == [1, 1, 1, 1, 2, 2, 2, 2, 4]
    assert np.count_nonzero(counts[corner]) == 4


def test_neighbours_in_a_triangle_are_the_corners_of_its_upright_cells():
    cuts = 3
    lattice = lattice_of(scene_of((TRIANGLE, BLACK)), cuts)

    def node(i, j):
        """The node at a corner, of which i and j are the shares of the second and the third vertex."""
        u, v = i / max(cuts - j, 1), j / cuts
        position = lattice.at(np.zeros(1, dtype=int), np.array([u]), np.array([v]))
        assert position.weights.max() == pytest.approx(1)
        return position.nodes[0, position.weights[0].argmax()]

    expected = np.zeros((len(lattice), len(lattice)))
    for i, j in product(range(cuts), range(cuts)):
        if i + j < cuts:
            corners = [node(i, j), node(i + 1, j), node(i, j + 1)]
            expected[np.ix_(corners, corners)] += 1
    np.testing.assert_array_equal(lattice.neighbours.toarray(), expected)


def test_a_lattice_of_nothing_is_empty():
    lattice = lattice_of(scene_of((FLOOR, BLACK)), 4, patch=np.zeros(0, dtype=int))
    assert len(lattice) == lattice.cells == 0
    assert lattice.neighbours.shape == (0, 0)
