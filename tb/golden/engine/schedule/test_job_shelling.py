"""The cells of a job: lists in which patches with many tests and patches with few alternate."""

import numpy as np

from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.shelling import Shelling
from golden.engine.config import PRESETS, Config
from golden.engine.frustum import hemisphere_record
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.ceiling_points import ceiling_points
from golden.engine.schedule.cycle_model import CycleModel, stage_work
from golden.engine.schedule.job_shelling import job_shelling
from golden.scene.builtin.tetra import tetra

CONFIG = Config().replace({"icu.rays": 1 << 12, "memsys.own_patches": 1024})


def cycles_of(shelling, record):
    model = CycleModel(CONFIG, patches=len(shelling.geometry))
    for work in stage_work(shelling, record, CONFIG):
        model.add(work)
    return model.cycles


def test_scattered_lists_are_predicted_to_take_fewer_cycles_and_leave_hits_as_they_are():
    scene = tetra(5)
    points, down = ceiling_points(scene)
    geometry = PatchGeometry.of(scene, CONFIG.numbers, points)
    record = hemisphere_record(Hemisphere(128, 32), geometry.coordinates, points[12], down)
    ascending = Shelling(geometry, CONFIG, cell=1.0, by_code=True)
    scattered = job_shelling(geometry, CONFIG, cell=1.0, by_code=True)
    assert cycles_of(scattered, record) < 0.9 * cycles_of(ascending, record)
    assert not len(scattered.cast(record)[0].differences(ascending.cast(record)[0]))


def test_the_thesis_machine_has_ascending_lists():
    scene = tetra(4)
    geometry = PatchGeometry.of(scene, CONFIG.numbers, scene.vertices[0])
    for preset, ascends in ("thesis", True), ("small", False):
        table = job_shelling(geometry, PRESETS[preset], cell=1.0).table
        listed = table.patches.read(table.entries(np.array([0])))
        assert (np.diff(listed) > 0).all() == ascends
