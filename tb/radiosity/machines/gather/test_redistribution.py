"""Entries move until all nodes have as many, but for one; only what changes its node moves."""

from itertools import pairwise

import numpy as np
import pytest
from scipy import sparse

from radiosity.machines.common.hypercube import WORDS, hypercube
from radiosity.machines.common.node_programs import run_program
from radiosity.machines.common.node_timing import NodeTiming
from radiosity.machines.gather.node_matrix import NodeMatrix
from radiosity.machines.gather.redistribution import moves_of, redistributed, redistribution_program
from tb.radiosity.machines.gather.nodes import drawn_matrix

pytestmark = pytest.mark.usefixtures("interpreted")


def given(seed, nodes, *, rows=60, most=20):
    rng = np.random.default_rng(seed)
    bounds = np.concatenate([[0], np.sort(rng.integers(0, rows + 1, nodes - 1)), [rows]])
    return NodeMatrix.of_rows(drawn_matrix(seed, rows, most=most), bounds)


@pytest.mark.parametrize("nodes", [1, 2, 8, 16])
@pytest.mark.parametrize("seed", range(3))
def test_the_first_nodes_have_one_entry_more(nodes, seed):
    before = given(seed, nodes)
    after, total = redistributed(before), before.matrix.nnz
    assert after.entry_counts.tolist() == [total // nodes + (node < total % nodes) for node in range(nodes)]
    assert after.matrix is before.matrix
    assert after.sharers <= 2
    # A node shares at most its first row with the node before it, and its last one with the node behind it.
    assert np.bincount(after.part_node[~after.is_owner], minlength=nodes).max() <= 1


def test_a_split_row_belongs_to_its_last_node():
    matrix = sparse.csr_array((np.ones(8), np.arange(8) % 4, [0, 3, 3, 5, 8]), shape=(4, 4))
    after = redistributed(NodeMatrix.of_rows(matrix, np.array([0, 4, 4])))
    assert after.entries.tolist() == [0, 4, 8]
    # Rows 0 and 1 are whole, or empty, in front of entry 4; row 2 ends behind it.
    assert after.rows.tolist() == [0, 2, 4]
    assert after.part_row.tolist() == [0, 1, 2, 2, 3]
    assert after.is_owner.tolist() == [True, True, False, True, True]
    assert after.is_split.tolist() == [False, True]


def with_lengths(lengths, nodes):
    """A matrix whose rows have so many entries, all of them in the last node."""
    rows = len(lengths)
    columns = np.concatenate([np.arange(length) % rows for length in lengths]) if rows else np.zeros(0)
    matrix = sparse.csr_array((np.ones(sum(lengths)), columns, np.cumsum([0, *lengths])), shape=(rows, rows))
    return NodeMatrix.of_rows(matrix, np.array([0] * nodes + [rows]))


def check_by_definition(lengths, nodes):
    """Entries are dealt one by one, and the owner of each row is looked up."""
    before, total = with_lengths(lengths, nodes), sum(lengths)
    node_of = [node for node in range(nodes) for _ in range(total // nodes + (node < total % nodes))]
    first = np.cumsum([0, *lengths])
    owner = [node_of[min(max(begin, end - 1), total - 1)] if total else nodes - 1
             for begin, end in pairwise(first)]
    after = redistributed(before)
    assert after.entries.tolist() == [node_of.index(node) if node in node_of else total for node in range(nodes)] + [
        total]
    assert after.rows.tolist() == [sum(one < node for one in owner) for node in range(nodes)] + [len(lengths)]
    moves, row_of = moves_of(before, after), np.repeat(np.arange(len(lengths)), lengths)
    assert moves.target.tolist() == sorted(set(node_of) - {nodes - 1})
    for target, entries, rows in zip(moves.target, moves.entries, moves.rows, strict=True):
        its = row_of[np.array(node_of) == target]
        assert (entries, rows) == (len(its), its[-1] - its[0] + 1)


@pytest.mark.parametrize(("lengths", "nodes"), [
    ([4, 0, 0, 4], 2), ([0, 0, 4, 4, 0, 0], 2), ([1, 0, 1, 0, 1], 3), ([2, 0, 0, 0, 1], 2), ([0, 3, 0, 3, 0], 8),
    ([0, 0, 0], 2)])
def test_rows_without_entries_at_a_boundary_have_the_owner_of_the_definition(lengths, nodes):
    check_by_definition(lengths, nodes)


@pytest.mark.parametrize("seed", range(40))
def test_entries_and_rows_are_those_of_the_definition(seed):
    """Most rows are empty, so that they lie at all boundaries; there may be fewer entries than nodes."""
    rng = np.random.default_rng(seed)
    lengths = (rng.integers(0, 6, 12) * (rng.random(12) < 0.4)).tolist()
    lengths[rng.integers(12)] += 1
    check_by_definition(lengths, int(rng.integers(1, 9)))


def test_a_heavy_row_is_shared_by_many_nodes():
    lengths = [60] + [1] * 15
    columns = np.concatenate([np.arange(length) % 16 for length in lengths])
    matrix = sparse.csr_array((np.ones(75), columns, np.cumsum([0, *lengths])), shape=(16, 16))
    assert redistributed(NodeMatrix.of_rows(matrix, np.arange(17))).sharers == 13


@pytest.mark.parametrize("seed", range(4))
def test_messages_take_each_node_from_what_it_has_to_what_it_gets(seed):
    before = given(seed, 8)
    after = redistributed(before)
    moves = moves_of(before, after)
    assert (moves.source != moves.target).all()
    gain = np.bincount(moves.target, moves.entries, 8) - np.bincount(moves.source, moves.entries, 8)
    assert np.array_equal(before.entry_counts + gain, after.entry_counts)
    kept = np.minimum(before.entries[1:], after.entries[1:]) - np.maximum(before.entries[:-1], after.entries[:-1])
    assert moves.entries.sum() == before.matrix.nnz - np.maximum(kept, 0).sum()
    assert (moves.rows >= 1).all()
    assert (moves.entries >= moves.rows - (np.diff(before.matrix.indptr) == 0).sum()).all()


def test_only_counts_travel_where_nothing_moves():
    timing = NodeTiming()
    before = NodeMatrix.of_rows(sparse.csr_array(np.ones((8, 8))), np.arange(0, 9, 2))
    moves = moves_of(before, redistributed(before))
    assert not len(moves.source)
    cube = hypercube(4, timing)
    ends = run_program(redistribution_program(moves, 4, timing), cube, np.zeros(4))
    assert (ends == 2 * timing.setup + 3 * timing.word + 8 * timing.operation).all()


def test_entries_travel_behind_the_structure_of_their_rows():
    timing = NodeTiming(setup=100, word=10, operation=1)
    before = NodeMatrix.of_rows(sparse.csr_array(np.ones((4, 4))), np.array([0, 3, 4]))
    moves, cube = moves_of(before, redistributed(before)), hypercube(2, timing)
    assert (moves.source.tolist(), moves.target.tolist(), moves.entries.tolist(), moves.rows.tolist()) == (
        [0], [1], [4], [1])
    ends = run_program(redistribution_program(moves, 2, timing), cube, np.zeros(2))
    counts = 100 + 10 + 4
    assert cube.sent[:2, WORDS].tolist() == [1 + 4 * 2 + 2, 1]
    assert ends.tolist() == [counts + 10 + 100, counts + 10 + 100 + 10 * 10 + 10]
