"""Nodes make rows without messages until a memory is full; then all stop after their row."""

import numpy as np
import pytest

from radiosity.machines.common.hypercube import MESSAGES, hypercube
from radiosity.machines.common.node_timing import NodeTiming
from radiosity.machines.gather.storage_sharing import make_rows

pytestmark = pytest.mark.usefixtures("interpreted")

TIMING = NodeTiming(setup=100, word=10)


def run(times, *, free, sizes=8, nodes=4):
    cube, count = hypercube(nodes, TIMING), len(times)
    found = make_rows(np.array(times), np.full(count, sizes), np.arange(0, count + 1, count // nodes),
                      np.array(free), cube, np.zeros(nodes, dtype=np.int64))
    return found, cube


def test_rows_that_fit_take_no_messages():
    found, cube = run([10, 20, 30, 40, 50, 60, 70, 80], free=[16] * 4)
    assert found.ends.tolist() == [30, 70, 110, 150]
    assert found.stored.tolist() == [2] * 4
    assert not found.is_full
    assert not cube.sent.any()


def test_all_nodes_stop_after_the_row_in_which_they_hear_that_a_memory_is_full():
    """Node 2 drops its second row at 200; a message of a word reaches 3 after one step, 0 and 1 after two."""
    found, cube = run([150] * 4 + [90] * 4 + [100] * 4 + [1000] * 4, free=[99, 99, 8, 99])
    assert found.is_full
    assert found.stored.tolist() == [3, 4, 1, 1]
    assert found.ends.tolist() == [450, 360, 200, 1000]
    assert found.ended.tolist() == [150, 300, 450, 0, 90, 180, 270, 360, 100, 0, 0, 0, 1000, 0, 0, 0]
    assert cube.sent[:, MESSAGES].tolist() == [0, 0, 2, 1, 0]


def test_a_node_that_knows_does_not_tell_again():
    found, cube = run([100] * 8, free=[8, 99, 8, 99], nodes=4)
    assert found.stored.tolist() == [1, 2, 1, 2]
    # Both are full at 200, before either message arrives.
    assert cube.sent[:, MESSAGES].sum() == 2 * 3
    found, cube = run([100, 100, 100, 100, 300, 900, 100, 100], free=[8, 99, 8, 99], nodes=4)
    assert found.stored.tolist() == [1, 2, 1, 2]
    assert cube.sent[:, MESSAGES].sum() == 3


def test_the_row_that_does_not_fit_is_dropped():
    found, _ = run([100, 100], free=[7], nodes=1)
    assert found.stored.tolist() == [0]
    assert found.ends.tolist() == [100]
