"""Whole frusta on many clusters: the same hits and sums in all networks, with all caches, however slow memory is."""

import pytest

from golden.config import PRESETS
from golden.noc.topology import TOPOLOGIES
from hw.memsys.cache_policy import CachePolicy
from hw.simulator.simulated_machine import SimulatedMachine
from hw.simulator.simulation_config import simulation_config
from tb.system.scenes import frusta

SCENES = {"cornell": 0.25, "lobby": 0.125, "room1627": 0.125, "man": 0.125}
# One cluster has no network.
MACHINES = [(TOPOLOGIES[0], 1), *((topology, clusters) for topology in TOPOLOGIES for clusters in (2, 4, 8, 16))]
POLICIES = CachePolicy.DIRECT, CachePolicy.LFU
MEMORIES = {"latency": 10}, {"latency": 5, "spread": 60, "shuffles": True, "seed": 3}


@pytest.mark.nightly
@pytest.mark.parametrize(("topology", "clusters"), MACHINES)
def test_hits_and_sums_are_golden(topology, clusters):
    config = simulation_config(PRESETS["paper"], clusters=clusters, topology=topology)
    remote = 0
    for scene, cell in SCENES.items():
        given = frusta(scene, config, cell=cell, rays=(64, 32), points=(5, 2))
        for policy in POLICIES:
            for memory in MEMORIES:
                with SimulatedMachine(config, policy=policy, **memory) as machine:
                    for frustum in given:
                        done = machine.cast(frustum.image, total=frustum.total, sums=True)
                        for name in "hits", "sums":
                            assert done.image[name].tobytes() == frustum.written[name].tobytes(), (
                                f"{scene}, {policy.name}, {memory}: {name}")
                        remote += done.total("memory_remote")
                    assert machine.port.outside == 0
    # Clusters have sent each other requests, or there is only one.
    assert (remote > 0) == (clusters > 1)
