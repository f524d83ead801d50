"""A cluster that explores a section for others' patches runs as far ahead of its tests as one that requests them."""

from dataclasses import replace

import numpy as np
import pytest

from golden.engine.config import PRESETS
from golden.engine.memsys.patches.patch_store import PatchStore
from golden.engine.noc.routing import route
from golden.engine.noc.topology import Topology
from radiosity.machines.engine.cluster_latencies import cluster_timing
from radiosity.machines.engine.exploration_timing import exploration_timing
from radiosity.machines.engine.job_latencies import bus_timing, joint_timing, store_timing
from radiosity.machines.engine.joint_cast import joint_cast
from radiosity.machines.engine.section_trace import SectionTrace, replay

pytestmark = pytest.mark.usefixtures("interpreted")

CONFIG, STAGES, LONG = PRESETS["paper"], 128, 100_000
TIMING, JOINT, BUS = cluster_timing(CONFIG), joint_timing(CONFIG), bus_timing(CONFIG, latency=50)
STORE = store_timing(CONFIG)


def blocked_trace():
    """A cell with a patch in each stage; the first patch has the only slot for all of the cast."""
    one, tests = np.arange(STAGES), np.ones(STAGES, dtype=np.int64)
    tests[0] = LONG
    return SectionTrace(cycles=np.full(STAGES, 200), searches=np.zeros(STAGES, dtype=np.int64),
                        is_barrier=np.zeros(STAGES, dtype=bool), first_cell=np.arange(STAGES + 1),
                        offset=np.zeros(STAGES, dtype=np.int64), entries=np.arange(STAGES + 1),
                        is_new=np.ones(STAGES, dtype=bool), patch=one, tests=tests)


def begun(times):
    """Stages that have begun while the first patch has the slot."""
    return np.count_nonzero(times.begins < LONG)


def alone(timing):
    return begun(replay(blocked_trace(), timing, slots=1, run_ahead=STAGES))


def others(home, joint=JOINT, bus=BUS, **path):
    return begun(joint_cast(
        [blocked_trace()], np.full(STAGES, home), TIMING, joint, routing=route(Topology("mesh", 2, 1), 2),
        buffer_flits=CONFIG.noc.buffer_flits, arbitration=CONFIG.noc.arbitration,
        router_cycles=CONFIG.noc.router_cycles, slots=1, run_ahead=STAGES, bus=bus, memsys=CONFIG.memsys,
        **path).times[0])


def test_as_many_stages_begin_as_where_patches_are_requested():
    """More than where a cluster holds them, by the 16 requests that a path has in flight behind its queue."""
    assert others(0) == alone(TIMING)
    assert others(-1) == alone(exploration_timing(TIMING, JOINT, BUS)) == others(0) + 16


def test_the_path_with_more_requests_in_flight_decides():
    """Patches may come from either; here they come from main memory."""
    few, more = ((replace(JOINT, outstanding=joint), replace(BUS, outstanding=bus)) for joint, bus in ((3, 5), (5, 3)))
    assert others(-1, *few) == alone(exploration_timing(TIMING, *few)) == others(0) + 5
    assert exploration_timing(TIMING, *more) == exploration_timing(TIMING, *few)


@pytest.mark.parametrize("requests", [3, 16])
def test_as_many_stages_begin_as_in_front_of_a_patch_store(requests):
    store = replace(STORE, requests=requests)
    stores = {"store": store, "stores": [PatchStore(STAGES)]}
    assert others(-1, **stores) == alone(exploration_timing(TIMING, JOINT, BUS, store))


def test_patches_of_the_own_memory_keep_their_queue():
    """Behind a store with a request in flight fewer patches of others wait than of the own ones."""
    assert STORE.waiting + 1 < TIMING.requests
    assert exploration_timing(TIMING, JOINT, BUS, replace(STORE, requests=1)) == TIMING
