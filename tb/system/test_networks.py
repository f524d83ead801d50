"""Jobs on many clusters: the same hits and sums in all networks, with all caches, however slow memory is."""

import random

import pytest

from golden.engine.config import PRESETS
from golden.engine.jobs.job import plan_job
from golden.engine.noc.topology import TOPOLOGIES
from hw.memsys.bus.cache_policy import CachePolicy
from radiosity.flow.simulator.simulation_config import simulation_config
from tb.lib.seed import NIGHTS, SEED
from tb.system.job_machine import JobMachine
from tb.system.job_memory import JobMemory
from tb.system.scenes import phase

SCENES = {"cornell": 0.25, "lobby": 0.125, "room1627": 0.125, "man": 0.125}
COUNTS = 2, 4, 8, 16
# In a night each network between as many clusters as are drawn, in four nights all. One cluster has no network.
MACHINES = [(TOPOLOGIES[0], 1), *(
    (topology, clusters) for number, topology in enumerate(TOPOLOGIES)
    for clusters in sorted(random.Random(f"{SEED} {number}").sample(COUNTS, min(NIGHTS, len(COUNTS)))))]
POLICIES = CachePolicy.DIRECT, CachePolicy.LFU
MEMORIES = {"latency": 10}, {"latency": 5, "spread": 60, "shuffles": True, "seed": 3}
POINTS = (5, 2, 0, 3)


@pytest.mark.nightly
@pytest.mark.parametrize(("topology", "clusters"), MACHINES)
def test_hits_and_sums_are_golden(topology, clusters):
    """Frusta for one cluster, and frusta cut for all of them; patches are those of a schedule."""
    config, remote = simulation_config(PRESETS["paper"], clusters=clusters, topology=topology), 0
    phases = [phase(scene, config, cell=cell, rays=(64, 64), points=POINTS, sets="scheduled", clusters=cut)
              for scene, cell in SCENES.items() for cut in (1, clusters)]
    expected = JobMemory(plan_job(phases, config))
    for policy in POLICIES:
        for memory in MEMORIES:
            with JobMachine(expected.job, expected=expected, **memory) as machine:
                remote += int(machine.right(policy=policy)["remote"].sum())
    # Clusters have sent each other requests, or there is only one.
    assert (remote > 0) == (clusters > 1)
