"""The host's plan of a step."""

from functools import lru_cache

import numpy as np

from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.shelling import Shelling
from golden.engine.config import PRESETS
from golden.engine.frustum import hemisphere_record
from golden.engine.icu.patch_setup import PatchSetup
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.ceiling_points import ceiling_points
from golden.engine.schedule.low_density import low_density
from golden.scene.open import open_scene
from radiosity.machines.paper.patch_tags import reached_sections
from radiosity.machines.paper.step_plan import plan_step

CONFIG = PRESETS["paper"]


@lru_cache
def planned(own_patches=4096, points=(5, 10)):
    scene = open_scene("lobby")
    origins, down = ceiling_points(scene)
    geometry = PatchGeometry.of(scene, CONFIG.numbers, origins)
    records = [hemisphere_record(Hemisphere(64, 16), geometry.coordinates, origins[point], down) for point in points]
    config = CONFIG.replace({"memsys.own_patches": own_patches})
    shelling = Shelling(geometry, config, cell=0.125)
    return records, shelling, plan_step(records, shelling, config, clusters=4, units=8, ratio=16)


def test_a_resident_set_is_what_was_found_in_the_section():
    records, shelling, plan = planned()
    found = low_density(records[0], shelling.geometry, shelling.table, CONFIG, ratio=16)
    reached = reached_sections(plan.partition, found.window)
    assert np.array_equal(plan.found, found.patches)
    for section, own in enumerate(plan.resident):
        assert np.array_equal(own, found.patches[reached[:, section]])
    assert 0 < len(plan.resident[0]) < len(found.patches) < len(shelling.geometry)


def test_half_of_the_memory_holds_the_patches_used_most():
    records, shelling, plan = planned(own_patches=16)
    found = low_density(records[0], shelling.geometry, shelling.table, CONFIG, ratio=16)
    for own, candidates in zip(plan.resident, planned()[2].resident, strict=True):
        assert len(own) == min(8, len(candidates))
        others = np.setdiff1d(candidates, own)
        assert found.frequency[own].min() >= found.frequency[others].max(initial=0)


def test_tags_are_of_all_frusta_of_the_step():
    records, shelling, plan = planned()
    wrong = 0
    for record in records:
        window = PatchSetup(record, CONFIG).patches(shelling.geometry).window
        reached, alone = reached_sections(plan.partition, window), planned(points=(5,))[2].tags
        for patch in range(len(shelling.geometry)):
            met = set(np.flatnonzero(reached[patch]).tolist())
            assert met <= set(plan.tags.destinations(patch).tolist())
            wrong += not met <= set(alone.destinations(patch).tolist())
    assert wrong


def test_traversal_units_are_those_of_the_pool():
    _, _, plan = planned()
    assert sum(map(len, plan.sectors)) == 8
    for section, sectors in zip(plan.partition.sections, plan.sectors, strict=True):
        assert sum(one.rays for one in sectors) == section.rays
