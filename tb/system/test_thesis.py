"""Preset `thesis`, the machine as the thesis describes it: hits and sums of its scenes are the golden model's."""

import pytest

from golden.cast.shelling import Shelling
from golden.config import PRESETS
from golden.frustum import Hemisphere, hemisphere_record
from golden.memory_map import machine_image
from golden.scene.open import open_scene
from golden.scene.patch_geometry import PatchGeometry
from golden.schedule.ceiling_points import ceiling_points
from golden.schedule.phase import machine_schedule
from hw.simulator.simulated_machine import SimulatedMachine
from hw.simulator.simulation_config import simulation_config

# Cells of tables 6.1 and 6.4, 16384 rays; the phase is scheduled from point 1, with Hi_Low_Ratio 16.
CELLS, RAYS, RATIO = (0.5, 0.0625), (256, 64), 16
REFERENCE, POINT = 0, 4
# Simulated with fewer rays per cluster: clearing the memory of the preset's rays takes 2^18 cycles after a reset.
CONFIG = simulation_config(PRESETS["thesis"], clusters=8, topology="torus")


def cast_on_the_machine(config, scene, *, cell, rays=RAYS):
    """A hemisphere from the ceiling on the simulated machine: each cluster's counters, and the length of its list."""
    opened, hemisphere = open_scene(scene), Hemisphere(*rays)
    points, down = ceiling_points(opened)
    geometry = PatchGeometry.of(opened, config.numbers, points)
    shelling = Shelling(geometry, config, cell=cell, by_code=True)
    reference, record = (hemisphere_record(hemisphere, geometry.coordinates, points[point], down)
                         for point in (REFERENCE, POINT))
    plan = machine_schedule(reference, geometry, shelling.table, config, ratio=RATIO)
    listed = [len(one.patches) for one in plan.subshells]
    assert sum(listed), "the machine has subshell lists"
    image = machine_image(record, geometry, shelling.table, config, plan, weights=hemisphere.polar_weights)
    expected = image.with_results(shelling.cast(record)[0])
    with SimulatedMachine(config, latency=10) as machine:
        done = machine.cast(image, total=int(hemisphere.polar_weights.sum()) * record.columns, sums=True)
    for name in "hits", "sums":
        assert done.image[name].tobytes() == expected[name].tobytes(), name
    return list(zip(done.counters, listed, strict=True))


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
