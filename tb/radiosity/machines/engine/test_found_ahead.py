"""A cluster that explores a section for others' patches runs as far ahead of its tests as one that requests them."""

from dataclasses import replace

import numpy as np
import pytest

from golden.engine.config import PRESETS
from golden.engine.memsys.patches.patch_store import PatchStore
from golden.engine.noc.routing import route
from golden.engine.noc.topology import Topology
from radiosity.machines.engine.cluster_cast import NO_CLUSTER
from radiosity.machines.engine.cluster_latencies import cluster_timing
from radiosity.machines.engine.found_ahead import found_ahead
from radiosity.machines.engine.job_latencies import bus_timing, joint_timing, store_timing
from radiosity.machines.engine.joint_cast import joint_cast
from radiosity.machines.engine.section_trace import SectionTrace, run_stages
from tb.radiosity.machines.engine.trace_source import TraceSource

pytestmark = pytest.mark.usefixtures("interpreted")

CONFIG, STAGES, LONG = PRESETS["paper"], 128, 100_000
TIMING, JOINT, BUS = cluster_timing(CONFIG), joint_timing(CONFIG), bus_timing(CONFIG, latency=50)


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


class OthersSource(TraceSource):
    """The stages of a trace, of which others hold all patches."""

    def items(self, stage, begin, cast):
        items, cycles = super().items(stage, begin, cast)
        return items._replace(owner=np.full(STAGES, NO_CLUSTER)), cycles


def alone(source=OthersSource, **ahead):
    return begun(run_stages(source(blocked_trace(), TIMING), TIMING, slots=1, run_ahead=STAGES, **ahead))


def others(home, joint=JOINT, bus=BUS, **path):
    return begun(joint_cast(
        [blocked_trace()], np.full(STAGES, home), TIMING, joint, routing=route(Topology("mesh", 2, 1), 2),
        buffer_flits=CONFIG.noc.buffer_flits, arbitration=CONFIG.noc.arbitration,
        router_cycles=CONFIG.noc.router_cycles, slots=1, run_ahead=STAGES, bus=bus, memsys=CONFIG.memsys,
        **path).times[0])


def test_as_many_stages_begin_as_where_patches_are_requested():
    """More than where a cluster holds them, by the 16 requests that a path has in flight behind its queue."""
    assert others(0) == alone(TraceSource)
    assert others(-1) == alone(ahead=found_ahead(TIMING, JOINT, BUS)) == others(0) + 16


def test_the_path_with_more_requests_in_flight_decides():
    """Patches may come from either; here they come from main memory."""
    few, more = ((replace(JOINT, outstanding=joint), replace(BUS, outstanding=bus)) for joint, bus in ((3, 5), (5, 3)))
    assert others(-1, *few) == alone(ahead=found_ahead(TIMING, *few)) == others(0) + 5
    assert found_ahead(TIMING, *more) == found_ahead(TIMING, *few)


@pytest.mark.parametrize("requests", [1, 3, 16])
def test_as_many_stages_begin_as_in_front_of_a_patch_store(requests):
    store = replace(store_timing(CONFIG), requests=requests)
    stores = {"store": store, "stores": [PatchStore(STAGES)]}
    assert others(-1, **stores) == alone(ahead=found_ahead(TIMING, JOINT, BUS, store))


def test_patches_of_the_own_memory_keep_their_queue():
    """However far a cluster runs ahead of others' patches."""
    assert alone(TraceSource, ahead=STAGES) == alone(TraceSource) < alone(ahead=STAGES)
