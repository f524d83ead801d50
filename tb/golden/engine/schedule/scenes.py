"""A scene with a frustum to schedule."""

from dataclasses import dataclass

import numpy as np

from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.shelling import Shelling
from golden.engine.config import PRESETS, Config
from golden.engine.frustum import FrustumRecord, hemisphere_record
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.scene.open import open_scene

__all__ = ["CONFIG", "Case", "case"]

CONFIG: Config = PRESETS["small"].replace({"icu.rays": 1 << 14})


@dataclass(frozen=True, eq=False)
class Case:
    """The input of a schedule."""

    geometry: PatchGeometry
    shelling: Shelling
    record: FrustumRecord


def case(name: str, *, rays=(128, 32), position=(0.3, 0.4), cell=0.125) -> Case:
    """A hemisphere that looks down from just below the ceiling."""
    scene = open_scene(name)
    lower, upper = scene.bounds
    point = lower + (upper - lower) * [*position, 0.999]
    geometry = PatchGeometry.of(scene, CONFIG.numbers, [point])
    record = hemisphere_record(Hemisphere(*rays), geometry.coordinates, point, np.array([0, 0, -1]))
    return Case(geometry, Shelling(geometry, CONFIG, cell=cell), record)
