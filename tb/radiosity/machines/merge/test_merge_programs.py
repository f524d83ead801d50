"""Times of exchanges are the source's equations 4.1 to 4.18."""

import numpy as np
import pytest

from radiosity.machines.common.hypercube import MESSAGES, hypercube
from radiosity.machines.common.node_programs import run_program
from radiosity.machines.common.node_timing import NodeTiming
from radiosity.machines.merge.exchange_steps import mesh_steps
from radiosity.machines.merge.merge_programs import all_to_all_ends, division_program, exchange_program

pytestmark = pytest.mark.usefixtures("interpreted")

TIMING = NodeTiming(setup=100, word=10, operation=3)
NODES = 16


def ends_of(sides, words):
    """The end of an exchange whose merges take no time; words by step."""
    steps = mesh_steps(sides)
    sent = np.repeat(np.array(words, dtype=np.int64)[:, None], NODES, axis=1)
    cube = hypercube(NODES, TIMING)
    return run_program(exchange_program(steps, sent, np.zeros_like(sent)), cube, np.zeros(NODES)), cube


@pytest.mark.parametrize(("sides", "setups"), [((16,), 15), ((4, 4), 6), ((2, 2, 2, 2), 4)])
def test_full_exchanges_take_equations_4_1_4_6_and_4_15(sides, setups):
    """Setups (P - 1), (M + K - 2) and d; words (P - 1) / P of the screen."""
    steps = mesh_steps(sides)
    cells = 160
    ends, _ = ends_of(sides, (steps.last - steps.first)[:, 0] * cells // NODES)
    assert (ends == setups * TIMING.setup + cells * 15 // 16 * TIMING.word).all()


def test_active_pixels_that_grow_take_equations_4_2_and_4_16():
    """F pixels in each node, evenly spread, grow by C_i in step i."""
    growth = np.array([40, 24, 8])
    held, words = 320, []
    for step in range(4):
        words.append(held // 2)
        held = held // 2 + (growth[step] if step < 3 else 0)
    expected = 15 / 16 * 320 + sum((2**(3 - i) - 1) / 2**(3 - i) * growth[i] for i in range(3))
    ends, _ = ends_of((2, 2, 2, 2), words)
    assert (ends == 4 * TIMING.setup + expected * TIMING.word).all()
    # A ring sends in step i a sixteenth, with what has come for it in all steps before.
    growth = np.arange(14, 0, -1)
    words = 20 + np.append(0, np.cumsum(growth))
    expected = 15 * 20 + sum((16 - i - 1) * growth[i - 1] for i in range(1, 15))
    ends, _ = ends_of((16,), words)
    assert (ends == 15 * TIMING.setup + expected * TIMING.word).all()


def test_an_exchange_from_each_to_all_takes_equation_4_18():
    """(P - 1) (1 + d) setups: a barrier of d exchanges follows each step."""
    cube = hypercube(NODES, TIMING)
    ends = all_to_all_ends(np.full((NODES, NODES), 7), cube, np.zeros(NODES))
    assert (ends == 15 * 5 * TIMING.setup + 15 * 7 * TIMING.word).all()
    assert (cube.sent[:NODES, MESSAGES] == 15 * 5).all()


def test_a_barrier_holds_all_nodes_until_the_slowest():
    words = np.full((NODES, NODES), 1)
    words[3, 2] = 500
    ends = all_to_all_ends(words, hypercube(NODES, TIMING), np.zeros(NODES))
    assert (ends == 15 * 5 * TIMING.setup + (14 + 500) * TIMING.word).all()


def test_a_merge_precedes_the_next_step():
    steps = mesh_steps((2, 2, 2, 2))
    words = np.ones((4, NODES), dtype=np.int64)
    ends = run_program(exchange_program(steps, words, np.full((4, NODES), 1000)), hypercube(NODES, TIMING),
                       np.zeros(NODES))
    assert (ends == 4 * (TIMING.setup + TIMING.word + 1000)).all()


def ends_of_division(division, *, is_direct=False, spans=0, nodes=NODES):
    counts = np.array([5] * 32 + [0] * 8)
    program = division_program(division, counts, np.full(nodes, spans), TIMING, counting=2, is_direct=is_direct)
    return run_program(program, hypercube(nodes, TIMING), np.zeros(nodes))


def test_recursion_takes_a_sum_of_all_lines_over_each_channel():
    sums = 4 * (TIMING.setup + 40 * TIMING.word) + (3 + 3) * 40 * TIMING.operation
    assert (ends_of_division("recursive") == sums).all()
    # All nodes get the bounds of all regions, if they send pixels to their owners.
    assert (ends_of_division("recursive", is_direct=True) == sums + 4 * TIMING.setup + 15 * 2 * TIMING.word).all()


def test_packing_counts_spans_sorts_shares_and_merges_them_over_each_channel():
    lists = 4 * TIMING.setup + 15 * 4 * TIMING.word + 2 * (4 + 8 + 16) * TIMING.operation
    sums = 4 * (TIMING.setup + 40 * TIMING.word) + 3 * 40 * TIMING.operation
    rest = (2 * 9 + 40 + 2 + 2 * 32 + 32 * 2 * 4 + 40) * TIMING.operation
    assert (ends_of_division("packed", spans=9) == sums + lists + rest).all()


def test_equal_shares_and_one_node_take_nothing():
    assert (ends_of_division("equal", spans=9) == 0).all()
    assert (ends_of_division("packed", spans=9, nodes=1) == 0).all()
