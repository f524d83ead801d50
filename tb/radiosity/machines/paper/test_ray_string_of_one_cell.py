"""Where every cell holds all patches, every ray refers to each of them once, in their order."""

from types import SimpleNamespace

import numpy as np

from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.shelling import Shelling
from golden.engine.config import PRESETS
from golden.engine.frustum import hemisphere_record
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.scene.open import open_scene
from radiosity.machines.paper.ray_string import ray_string

CONFIG = PRESETS["paper"]


def test_each_ray_refers_to_the_last_patch_and_the_next_to_the_first():
    scene, point = open_scene("furnace:1"), np.array((0.5, 0.5, 0.9))
    geometry = PatchGeometry.of(scene, CONFIG.numbers, point[None])
    record = hemisphere_record(Hemisphere(8, 4), geometry.coordinates, point, np.array((0.0, 0, -1)))
    shelling = Shelling(geometry, CONFIG, cell=1.0)
    real = shelling.table
    table = SimpleNamespace(
        position=real.position, shape=real.shape, cell=real.cell, number=lambda index: np.zeros(len(index), dtype=int),
        count=np.array([6]), entries=lambda cells: np.tile(np.arange(6), len(cells)),
        patches=SimpleNamespace(read=lambda entries: entries))
    found = ray_string(record, shelling.cast(record)[0], table, CONFIG)
    assert found.tolist() == [*range(6)] * 32
