"""Each item is worked on once, by its owner or by a node that requested it along the ring."""

import numpy as np
import pytest

from radiosity.machines.common.hypercube import ring
from tb.radiosity.machines.koan.programs import QUICK, run_programs

WORK = 1_000_000
MESSAGE = QUICK.setup + 2 * QUICK.word


def items(*counts):
    return [[(WORK, [])] * count for count in counts]


@pytest.mark.parametrize("nodes", [1, 2, 8, 32])
def test_every_item_is_worked_on_once_and_each_last_request_goes_once_around(nodes):
    counts = np.random.default_rng(nodes).integers(0, 20, nodes)
    found = run_programs(items(*counts), pages=1, is_shared=True)
    assert (found.times.node >= 0).all()
    assert ((found.times.ends - found.times.begins) >= WORK).all()
    assert found.counts["ring_hops"].sum() >= (nodes * nodes if nodes > 1 else 0)
    stolen = (found.times.node != np.repeat(np.arange(nodes), counts)).sum()
    assert found.counts["ring_requests"].sum() == stolen + (nodes if nodes > 1 else 0)


def test_a_request_without_work_left_takes_as_many_hops_as_nodes():
    found = run_programs(items(0, 0, 0, 0, 0, 0, 0, 0), pages=1, is_shared=True)
    assert found.counts["ring_hops"].tolist() == [8] * 8
    # Each of the nodes passes on one request after the other; with links of their own they do not meet.
    assert (found.times.stops >= 8 * MESSAGE).all()


def test_a_node_without_items_takes_the_last_of_the_first_node_on_the_ring_that_has_one():
    around = ring(4).tolist()
    counts = [0] * 4
    counts[around[2]] = 3
    found = run_programs(items(*counts), pages=1, is_shared=True)
    first = int(np.argmin(np.where(found.times.node == around[2], 1 << 60, found.times.begins)))
    assert first == 2
    assert found.times.node[0] == around[2]
    # The node before the owner has its request there first.
    assert found.times.node[2] == around[1]
    assert found.times.begins[2] == MESSAGE + MESSAGE
    # Hops count at the node that requests: to the owner one and two, then four around the ring for each node.
    assert found.counts["ring_hops"][around].tolist() == [2 + 4, 1 + 4, 4, 4]


def test_items_that_are_not_shared_stay():
    found = run_programs(items(5, 0, 1, 2), pages=1, is_shared=False)
    assert found.times.node.tolist() == [0] * 5 + [2] + [3, 3]
    assert found.times.stops.tolist() == [5 * WORK, 0, WORK, 2 * WORK]
    assert found.counts["ring_requests"].sum() == 0


def test_work_is_shared_evenly_before_references():
    programs = [[(1000, [(1, 0, 0, 0), (0, 0, 0, 0)])], []]
    found = run_programs(programs, pages=2)
    fetched = next(time for time, node, page, code in found.log if node == 0 and page == 1 and code == 1)
    assert found.times.ends[0] == fetched + 500


def test_sharing_balances():
    counts = (40, 0, 3, 9)
    alone, shared = (run_programs(items(*counts), pages=1, is_shared=each).times.stops.max() for each in (False, True))
    assert alone == 40 * WORK
    assert shared < 1.15 * WORK * sum(counts) / 4 + 4 * MESSAGE
