"""The host sends patches in their order to whoever requests them first; a full memory ends the phase for all."""

import numpy as np
import pytest

from radiosity.machines.common.hypercube import MESSAGES, WORDS, hypercube
from radiosity.machines.common.node_timing import NodeTiming
from radiosity.machines.gather.demand_driven import demand_rows

pytestmark = pytest.mark.usefixtures("interpreted")

TIMING = NodeTiming(setup=100, word=10)


def run(times, *, nodes, free=10**9, granularity=1, timing=TIMING):
    cube = hypercube(nodes, timing)
    found = demand_rows(np.array(times), np.full(len(times), 8), np.full(nodes, free), cube,
                        np.zeros(nodes, dtype=np.int64), granularity=granularity)
    return found, cube


def test_one_node_alternates_with_the_host():
    found, cube = run([1000, 2000], nodes=1)
    # A request takes 100 + 10, the reply 100 and 7 words; the last one is a word.
    assert found.ended.tolist() == [110 + 170 + 1000, 1280 + 110 + 170 + 2000]
    assert found.ends.tolist() == [3560 + 110 + 110]
    assert cube.sent[:, MESSAGES].tolist() == [3, 3]
    assert cube.sent[:, WORDS].tolist() == [3, 7 + 7 + 1]


def test_each_row_is_made_once_and_by_the_node_that_is_idle_first():
    times = np.random.default_rng(4).integers(1_000, 90_000, 40)
    found, _ = run(times, nodes=4)
    assert not found.is_full
    assert (found.node >= 0).all()
    idle = np.zeros(4, dtype=int)
    for row, time in enumerate(times):
        # The next row goes to the node that has ended its rows first: requests come in the order of these times.
        assert row < 4 or found.node[row] == idle.argmin()
        assert idle[found.node[row]] + time < found.ended[row]
        idle[found.node[row]] = found.ended[row]
    assert (np.bincount(found.node) >= 8).all()


def test_the_host_sends_one_message_after_the_other():
    found, _ = run([5000] * 4, nodes=4, timing=NodeTiming(setup=100, word=0))
    assert np.sort(found.ended).tolist() == [5200, 5300, 5400, 5500]


def test_granules_are_requested_at_once():
    found, cube = run([1000] * 10, nodes=2, granularity=4)
    assert found.node.tolist() == [0] * 4 + [1] * 4 + [0] * 2
    assert cube.sent[2, MESSAGES] == 3 + 2
    assert cube.sent[2, WORDS] == 10 * 7 + 2


def test_each_row_of_a_granule_takes_its_own_time():
    found, _ = run([1000, 2000, 4000, 8000], nodes=1, granularity=3)
    # Requests take 100 + 10, the replies 100 and 7 words of each row.
    assert found.ended.tolist() == [420 + 1000, 420 + 3000, 420 + 7000, 7420 + 280 + 8000]


def test_small_granules_balance_best():
    times = np.random.default_rng(1).integers(2, 7, 220) * 10**9
    ends = [run(times, nodes=16, granularity=one, timing=NodeTiming())[0].ends.max() for one in (1, 4, 16)]
    assert ends[0] < ends[1] < ends[2]


@pytest.mark.parametrize("granularity", [1, 3])
def test_a_full_memory_ends_the_phase(granularity):
    """Each node stores two rows; what it makes of a third one is dropped, and no more is sent then."""
    found, _ = run([1000] * 12, nodes=2, free=16, granularity=granularity)
    assert found.is_full
    assert np.bincount(found.node[found.node >= 0]).tolist() == [2, 2]
    assert (found.ends > found.ended.max() + 1000).all()


def test_the_host_serves_no_more_when_it_knows_that_a_memory_is_full():
    """Row 2 fits no node; while node 0 makes it, node 1 makes row 3, and gets none after that."""
    found = demand_rows(np.full(40, 5000), np.where(np.arange(40) == 2, 99, 8), np.full(2, 90), hypercube(2, TIMING),
                        np.zeros(2, dtype=np.int64))
    assert np.flatnonzero(found.node >= 0).tolist() == [0, 1, 3]


def test_all_nodes_hear_of_the_end_after_the_last_one_waits():
    found, _ = run([1000, 50_000], nodes=2)
    assert (found.ends > 50_000).all()
