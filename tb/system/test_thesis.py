"""Preset `thesis`, the machine as the thesis describes it: hits and sums of its scenes are the golden model's."""

import pytest

from golden.engine.config import PRESETS
from golden.engine.jobs.job import plan_job
from radiosity.flow.simulator.simulation_config import simulation_config
from tb.system.job_machine import JobMachine
from tb.system.scenes import phase

# Cells of tables 6.1 and 6.4, 16384 rays; the phase is scheduled from point 1, with Hi_Low_Ratio 16.
CELLS, RAYS = (0.5, 0.0625), (256, 64)
POINTS = (4, 5)
# Simulated with fewer rays per cluster: clearing the memory of the preset's rays takes 2^18 cycles after a reset.
CONFIG = simulation_config(PRESETS["thesis"], clusters=8, topology="torus")


def cast_on_the_machine(config, scene, *, cell, rays=RAYS):
    """Hemispheres from the ceiling on the simulated machine, a section of each on its own cluster: each cluster's
    counters, and the length of its list.
    """
    request = phase(scene, config, cell=cell, rays=rays, points=POINTS, sets="scheduled")
    listed = [len(one.patches) for one in request.plan.subshells]
    assert sum(listed), "the machine has subshell lists"
    job = plan_job([request], config)
    # Which frustum is which cluster's, the planner decides.
    assert sorted(job.descriptors["cluster"][1:]) == sorted([*range(len(listed))] * len(POINTS))
    with JobMachine(job, latency=10) as machine:
        machine.right()
        return list(zip(machine(machine.host.counters()), listed, strict=True))


@pytest.mark.nightly
@pytest.mark.parametrize("cell", CELLS)
@pytest.mark.parametrize("scene", ["lobby", "room1627"])
def test_scenes(scene, cell):
    for counters, listed in cast_on_the_machine(CONFIG, scene, cell=cell):
        assert counters["memory_answered"] >= listed, "traversal requests the patches of subshells"


@pytest.mark.nightly
def test_deferred_requests():
    """So few slots that requests meet absent rays."""
    config = CONFIG.replace({"ctu.ray_slots": 1 << 6})
    found = cast_on_the_machine(config, "room1627", cell=min(CELLS), rays=(64, 16))
    assert sum(counters["traversal_deferrals"] for counters, _ in found)


@pytest.mark.parametrize("config", [PRESETS["thesis"], CONFIG])
def test_the_preset_is_the_thesis_machine(config):
    assert config.ctu.subshells
    assert config.ctu.subshell_barrier
    assert config.ctu.run_ahead == 15
    assert (config.memsys.cache_policy, config.memsys.resident_set) == ("lfu", "found")
