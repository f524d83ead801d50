"""Strings of requests for caches: what clusters request in castings of a phase."""

from dataclasses import dataclass

from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.shelling import Shelling
from golden.engine.config import Config
from golden.engine.frustum import hemisphere_record
from golden.engine.memsys.bus.reference_strings import ReferenceStrings, interleaved
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.ceiling_points import ceiling_points
from golden.engine.schedule.phase import Schedule, schedule
from golden.scene.open import open_scene

__all__ = ["POINTS", "SCENES", "Strings", "cast_strings"]

SCENES = ("lobby", "room1627", "cubes", "man", "phone")
# Ceiling points, numbered from 1; the phase is scheduled at the first of all.
POINTS = (4, 7, 10, 13)


@dataclass(frozen=True, kw_only=True, eq=False)
class Strings:
    """``plan`` is the phase, ``requests`` what its clusters request, frustum by frustum."""

    plan: Schedule
    requests: ReferenceStrings

    def joined(self) -> dict:
        """One string each of cells and of patches, as a cache that all clusters share sees them."""
        return {"cells": interleaved(self.requests.cells), "patches": interleaved(self.requests.patches)}


def cast_strings(name: str, config: Config, *, clusters: int, hemisphere: Hemisphere, cell: float,
                 points: tuple[int, ...] = POINTS) -> Strings:
    """Of a hemisphere at each of some points of a scene's ceiling."""
    scene = open_scene(name)
    origins, down = ceiling_points(scene)
    geometry = PatchGeometry.of(scene, config.numbers, origins)
    shelling = Shelling(geometry, config, cell=cell)
    records = [hemisphere_record(hemisphere, geometry.coordinates, origins[point - 1], down) for point in (1, *points)]
    plan = schedule(records[0], geometry, shelling.table, config, clusters=clusters, ratio=64)
    return Strings(plan=plan, requests=ReferenceStrings.of(shelling, records[1:], plan.partition.sections))
