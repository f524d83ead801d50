"""Rows with the nodes' numbers: products and rows are those of the scene's numbers, bit for bit."""

import numpy as np
import pytest

from radiosity.machines.common.assignment import assign, of_rows
from radiosity.machines.gather.node_matrix import NodeMatrix, renumbered, restored
from tb.radiosity.machines.gather.nodes import drawn_matrix

pytestmark = pytest.mark.usefixtures("interpreted")


def same(one, other):
    return all(getattr(one, name).tobytes() == getattr(other, name).tobytes() for name in ("data", "indices", "indptr"))


@pytest.mark.parametrize("nodes", [1, 4, 16])
@pytest.mark.parametrize("seed", range(3))
def test_renumbering_keeps_products_and_comes_back_byte_for_byte(nodes, seed):
    matrix, rng = drawn_matrix(seed, 40, most=12), np.random.default_rng(seed)
    assignment = of_rows(np.split(rng.permutation(40), np.sort(rng.integers(0, 41, nodes - 1))))
    machine, vector = renumbered(matrix, assignment), rng.random(40)
    assert np.array_equal(machine @ vector[assignment.order], (matrix @ vector)[assignment.order])
    assert same(restored(machine, assignment), matrix)


def test_columns_are_new_numbers_without_a_table_between():
    """The column of an entry is the place of its patch in the nodes' lists put together."""
    matrix, assignment = drawn_matrix(3, 12, most=5), assign("random", 12, 4)
    machine = renumbered(matrix, assignment)
    for row, patch in enumerate(assignment.order):
        assert assignment.order[machine[[row]].indices].tolist() == matrix[[patch]].indices.tolist()


def test_whole_rows_have_one_part_each():
    matrix = NodeMatrix.of_rows(drawn_matrix(1, 20, most=6), np.array([0, 5, 5, 11, 20]))
    assert matrix.part_row.tolist() == list(range(20))
    assert np.bincount(matrix.part_node, minlength=4).tolist() == [5, 0, 6, 9] == matrix.part_counts.tolist()
    assert matrix.is_owner.all()
    assert not matrix.is_split.any()
    assert matrix.sharers == 1


def cut(matrix, entries):
    """Entries at bounds; the last node of a row owns it."""
    entries = np.array(entries)
    last = np.maximum(matrix.indptr[1:] - 1, matrix.indptr[:-1])
    owner = np.searchsorted(entries[1:], last, side="right")
    return NodeMatrix(matrix=matrix, entries=entries, rows=np.searchsorted(owner, np.arange(len(entries))))


@pytest.mark.parametrize("seed", range(4))
def test_parts_of_rows_add_up_to_whole_ones(seed):
    rng, matrix = np.random.default_rng(seed), drawn_matrix(seed, 15, most=15)
    parted = cut(matrix, [0, *np.sort(rng.integers(0, matrix.nnz, 15)), matrix.nnz])
    vector = rng.random(15)
    assert parted.sharers > 1
    assert np.allclose(parted.completed(parted.partial_products(vector)), matrix @ vector, rtol=1e-14, atol=0)


def test_a_row_of_many_nodes_is_added_in_pairs_of_groups():
    """Channel 0 adds nodes 0 and 1, and nodes 2 and 3; channel 1 adds both sums. The rounding shows the order."""
    matrix = drawn_matrix(0, 1, most=0)
    matrix = type(matrix)((np.ones(4), np.zeros(4, dtype=int), [0, 4]), shape=(1, 1))
    parted, tiny = cut(matrix, [0, 1, 2, 3, 4]), 2.0**-53
    assert parted.sharers == 4
    assert parted.is_split.tolist() == [False, True, True, True]
    assert parted.completed(np.array([1, tiny, tiny, 1])).tolist() == [2.0]
    assert parted.completed(np.array([tiny, tiny, 1, 1])).tolist() == [2 + 2 * tiny]
