"""Iterations take the times of Eqs. 2.7, 2.11, 2.15 and 2.16, and split rows what sections 2.6.1 and 2.6.2 add."""

import numpy as np
import pytest
from scipy import sparse

from radiosity.machines.common.hypercube import MESSAGES, WORDS, hypercube
from radiosity.machines.common.node_programs import run_program
from radiosity.machines.common.node_timing import NodeTiming
from radiosity.machines.gather.node_matrix import NodeMatrix
from radiosity.machines.gather.redistribution import redistributed
from radiosity.machines.gather.solution_programs import iteration_program, preparation_program, renumbering_program

pytestmark = pytest.mark.usefixtures("interpreted")

TIMING = NodeTiming()
# Scalars that an iteration reduces, its set-ups for each channel, and its operations on a row.
SOLVERS = {"gauss-jacobi": (2, 2, 6), "conjugate-gradient": (4, 3, 18)}


def even(nodes, *, rows=64, entries=16):
    """Rows with as many entries each, in whole rows."""
    indptr = np.arange(0, rows * entries + 1, entries)
    matrix = sparse.csr_array((np.ones(rows * entries), np.tile(np.arange(entries), rows), indptr), shape=(rows, rows))
    return NodeMatrix.of_rows(matrix, np.arange(0, rows + 1, rows // nodes))


def split(nodes, *, rows=63):
    """Entries in equal shares, all nodes' bounds inside of rows."""
    matrix = even(1, rows=rows, entries=nodes + 1)
    return redistributed(NodeMatrix.of_rows(matrix.matrix, np.append(np.zeros(nodes, dtype=int), rows)))


def run(program, nodes, rounds=1):
    cube = hypercube(nodes, TIMING)
    ends = run_program(program, cube, np.zeros(nodes), rounds=rounds)
    return int(ends.max()), cube.sent[:nodes]


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("nodes", [1, 2, 16, 64])
@pytest.mark.parametrize("rounds", [1, 3])
def test_an_iteration_takes_its_equation(solver, nodes, rounds):
    scalars, setups, each = SOLVERS[solver]
    channels = nodes.bit_length() - 1
    operations = (2 * 64 * 16 + each * 64) // nodes
    words = (nodes - 1) * 64 // nodes + scalars * channels
    found, sent = run(iteration_program(solver, even(nodes), TIMING), nodes, rounds)
    assert found == rounds * (operations * TIMING.operation + setups * channels * TIMING.setup + words * TIMING.word)
    assert (sent == np.array([setups * channels, words]) * rounds).all()


def test_the_node_with_most_entries_sets_the_time():
    matrix = even(4)
    uneven = NodeMatrix.of_rows(matrix.matrix, np.array([0, 4, 20, 52, 64]))
    late, early = (run(iteration_program("gauss-jacobi", one, TIMING), 4)[0] for one in (uneven, matrix))
    assert late - early > 2 * 16 * 16 * TIMING.operation


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_shift_takes_a_message_of_a_word_and_an_addition(solver):
    matrix = split(8)
    assert matrix.is_split.tolist() == [False] + [True] * 7
    with_shift = iteration_program(solver, matrix, TIMING, completion="shift")
    # The same entries and owners, as if no row were split.
    whole = NodeMatrix(matrix=matrix.matrix, entries=matrix.entries, rows=matrix.rows)
    whole.__dict__["is_split"] = np.zeros(8, dtype=bool)
    without = iteration_program(solver, whole, TIMING, completion="shift")
    assert len(with_shift.work) - len(without.work) == 2
    sent = run(with_shift, 8)[1] - run(without, 8)[1]
    assert sent.tolist() == [[1, 1]] * 7 + [[0, 0]]
    extra = run(with_shift, 8)[0] - run(without, 8)[0]
    assert extra == TIMING.setup + TIMING.word + TIMING.operation


def test_merged_gauss_jacobi_takes_a_word_and_an_addition_for_each_channel_and_no_set_up():
    matrix = split(8)
    merged, shifted = (iteration_program("gauss-jacobi", matrix, TIMING, completion=one) for one in ("merge", "shift"))
    assert (run(merged, 8)[1][:, MESSAGES] == 2 * 3).all()
    # Both ends of a slice between its neighbours are parts: a row of it is sent twice.
    parts = np.array([matrix.part_counts[:1 << channel].sum() - (1 << channel) + 1 for channel in range(3)])
    assert merged.words[1:4, 0].tolist() == parts.tolist()
    assert merged.work[2:5].tolist() == [[TIMING.operation] * 8] * 3
    assert run(merged, 8)[0] < run(shifted, 8)[0]


def test_merged_conjugate_gradients_send_two_words_more_with_the_first_sum():
    matrix = split(8)
    merged, shifted = (iteration_program("conjugate-gradient", matrix, TIMING, completion=one)
                       for one in ("merge", "shift"))
    sent = [run(one, 8)[1] for one in (merged, shifted)]
    assert (sent[0][:, MESSAGES] == 3 * 3).all()
    assert (sent[0][:, WORDS] - sent[1][:, WORDS]).tolist() == [3 * 2 - 1] * 7 + [3 * 2]
    assert merged.work.sum() > shifted.work.sum()


def test_only_groups_that_share_a_row_exchange_a_part():
    """Rows of 4 entries, 6 for each of 4 nodes: nodes 0 and 1 share a row, as do 2 and 3, but not 1 and 2."""
    matrix = redistributed(NodeMatrix.of_rows(even(1, rows=6, entries=4).matrix, np.array([0, 6, 6, 6, 6])))
    assert matrix.is_split.tolist() == [False, True, False, True]
    merged = iteration_program("gauss-jacobi", matrix, TIMING)
    assert merged.work[2].tolist() == [TIMING.operation] * 4
    assert merged.work[3].tolist() == [0] * 4
    assert merged.words[2].tolist() == [3] * 4


def test_before_its_first_iteration_gauss_jacobi_distributes_and_conjugate_gradients_scale():
    time, sent = run(preparation_program("gauss-jacobi", even(4), TIMING), 4)
    assert time == 2 * TIMING.setup + 48 * TIMING.word
    assert (sent == (2, 48)).all()
    time, sent = run(preparation_program("conjugate-gradient", even(4), TIMING), 4)
    assert time == 7 * 16 * TIMING.operation + 2 * (TIMING.setup + TIMING.word)
    assert (sent == (2, 2)).all()


def test_renumbering_takes_a_concatenation_and_an_operation_for_each_element_and_entry():
    time, sent = run(renumbering_program(even(4), TIMING), 4)
    assert time == 2 * TIMING.setup + 48 * TIMING.word + (64 + 16 * 16) * TIMING.operation
    assert (sent == (2, 48)).all()
