"""Boxes are tallied to the cells of a mesh, which is cut by a table of sums or along a Hilbert curve."""

import numpy as np
import pytest

from golden.base.errors import InputError
from radiosity.machines.merge.mesh_load import (
    check_mesh,
    edge_loads,
    halve_mesh,
    hilbert_index,
    hilbert_shares,
    mesh_loads,
)
from radiosity.machines.merge.work_weights import TRIANGLES_ALONE, WorkWeights

pytestmark = pytest.mark.usefixtures("interpreted")


def test_a_box_adds_its_weight_divided_by_its_cells():
    boxes = np.array([[0, 0, 3, 3], [2, 1, 9, 6], [8, 8, 8, 8]])
    loads = mesh_loads(boxes, TRIANGLES_ALONE, 4, 16, 16)
    expected = np.zeros((4, 4))
    expected[0, 0] = 1
    expected[:2, :3] += 1 / 6
    expected[2, 2] = 1
    assert loads == pytest.approx(expected)


def test_spans_are_divided_by_the_cells_of_their_row_and_pixels_are_in_one():
    loads = mesh_loads(np.array([[2, 1, 9, 6]]), WorkWeights(triangle=0, span=1, pixel=0), 4, 16, 16)
    assert loads[:2, :3] == pytest.approx(np.array([[1.0] * 3, [1.0] * 3]))
    assert loads.sum() == pytest.approx(6)
    loads = mesh_loads(np.array([[2, 1, 9, 6]]), WorkWeights(triangle=0, span=0, pixel=1), 4, 16, 16)
    assert loads[:2, :3].tolist() == [[6, 12, 6], [6, 12, 6]]


def test_boxes_in_a_row_or_a_column_count_whole_on_edges_and_others_in_part():
    def edges(box, weights=TRIANGLES_ALONE):
        return edge_loads(np.array([box]), weights, 4, 16, 16)

    assert edges([0, 0, 15, 3])[0, 0].tolist() == [1, 1, 1, 0]
    assert edges([0, 0, 15, 3])[1].sum() == 0
    assert edges([0, 0, 3, 11])[1, :, 0].tolist() == [1, 1, 0, 0]
    both = edges([0, 0, 7, 7])
    assert both[0, :2, 0].tolist() == [1 / 4, 1 / 4]
    assert both[1, 0, :2].tolist() == [1 / 4, 1 / 4]
    assert edges([0, 1, 7, 5], WorkWeights(triangle=0, span=2, pixel=9))[0, :2, 0].tolist() == [6, 4]


def drawn(seed, mesh=16):
    return np.random.default_rng(seed).random((mesh, mesh))**4


@pytest.mark.parametrize("seed", range(4))
def test_the_longer_side_is_cut_where_the_halves_are_most_equal(seed):
    loads = drawn(seed)
    levels = halve_mesh(loads, 3)
    for level, owner in enumerate(levels[:-1]):
        for node in range(1 << level):
            rows, columns = np.nonzero(owner == node)
            part = loads[rows.min():rows.max() + 1, columns.min():columns.max() + 1]
            halves = np.unique(levels[level + 1][owner == node])
            assert halves.tolist() == [2 * node, 2 * node + 1]
            along = part.sum(axis=0) if part.shape[1] > part.shape[0] else part.sum(axis=1)
            best = min(abs(along[:at].sum() - along[at:].sum()) for at in range(1, len(along)))
            sums = [loads[levels[level + 1] == half].sum() for half in halves]
            assert abs(sums[0] - sums[1]) == pytest.approx(best)


@pytest.mark.parametrize("mesh", [2, 8, 32])
def test_a_hilbert_curve_goes_from_neighbour_to_neighbour_through_all_cells(mesh):
    index = hilbert_index(mesh)
    assert np.array_equal(np.sort(index.ravel()), np.arange(mesh * mesh))
    y, x = np.divmod(np.argsort(index.ravel()), mesh)
    assert (np.abs(np.diff(y)) + np.abs(np.diff(x)) == 1).all()


def test_the_curve_is_cut_at_equal_shares():
    loads = drawn(5)
    owner = hilbert_shares(loads, 16)
    along = owner.ravel()[np.argsort(hilbert_index(16).ravel())]
    assert (np.diff(along) >= 0).all()
    sums = np.bincount(owner.ravel(), loads.ravel(), 16)
    assert (np.abs(sums - loads.sum() / 16) <= loads.max()).all()
    assert hilbert_shares(np.zeros((4, 4)), 4).max() == 0


def test_wrong_meshes_are_refused():
    for mesh in (0, 6, 32):
        with pytest.raises(InputError, match=f"power of two that divides 48 x 16 pixels, not {mesh}"):
            check_mesh(mesh, 48, 16)
    with pytest.raises(InputError, match="Nodes must be at most the 16 cells of the mesh, not 32"):
        halve_mesh(np.ones((4, 4)), 5)


def test_a_cell_goes_to_the_share_that_has_its_middle():
    """A cell whose middle is on the cut goes to the upper share, one that has most below the cut to the lower."""
    index = hilbert_index(2).ravel()
    for along, expected in (([3, 2, 3, 0], [0, 1, 1, 1]), ([1, 4, 2, 1], [0, 0, 1, 1])):
        owner = hilbert_shares(np.array(along, dtype=float)[index].reshape(2, 2), 2)
        assert owner.ravel()[np.argsort(index)].tolist() == expected
