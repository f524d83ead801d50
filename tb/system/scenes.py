"""Phases for the machine: frusta of built-in scenes, as a host requests them."""

import functools
from collections import defaultdict
from collections.abc import Sequence

import numpy as np

from golden.cast.default_camera import default_camera
from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.engine.cast.shadow_frusta import shadow_frusta
from golden.engine.cast.shelling import Shelling
from golden.engine.config import Config
from golden.engine.frustum import hemisphere_record, screen_record
from golden.engine.jobs.job import PhaseRequest
from golden.engine.jobs.result_formats import HitFormat
from golden.engine.memsys.patches.cell_table import CellTable
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.ceiling_points import ceiling_points
from golden.engine.schedule.phase import Schedule, machine_schedule
from golden.engine.schedule.resident_sets import ResidentSets
from golden.engine.schedule.sections import Partition
from golden.engine.schedule.subshells import NO_SUBSHELLS
from golden.scene.open import open_scene
from tb.golden.engine.cast.drawn_shadows import drawn_rays

__all__ = ["geometry", "phase", "shadow_phases"]

# Of the sparse casting that finds resident sets and subshells, and the point that it is from.
RATIO, REFERENCE = 16, 0


@functools.lru_cache(maxsize=8)
def geometry(scene: str, config: Config, cell: float) -> tuple[PatchGeometry, CellTable]:
    """Patches and cells of a built-in scene; ``cell`` as a share of its longest side."""
    opened = open_scene(scene)
    eye = (opened.camera or default_camera(opened)).eye
    made = PatchGeometry.of(opened, config.numbers, [*ceiling_points(opened)[0], eye])
    return made, Shelling(made, config, cell=cell, by_code=True).table


def phase(scene: str, config: Config, *, cell: float, rays: tuple[int, int] = (32, 8), points=(5,),
          pixels: tuple[int, int] | None = None, sets: str | Sequence[Sequence[int]] = (), **given) -> PhaseRequest:
    """Hemispheres from the ceiling with all results, or screens with hits.

    Parameters
    ----------
    scene, cell
        Name of a built-in scene, and cell size as a share of its longest side.
    rays
        Azimuths and polars.
    points
        Which of `ceiling_points`, a frustum each.
    pixels
        Across and down: the scene's view instead, as often as there are points.
    sets
        Patches in the memories of the clusters: "scheduled" for those of a schedule, or the numbers for each cluster.
        Default: see `phase_image`.
    given
        Other parameters of `PhaseRequest`.
    """
    opened, (patches, table) = open_scene(scene), geometry(scene, config, cell)
    if pixels:
        screen = Screen(camera=opened.camera or default_camera(opened), width=pixels[0], height=pixels[1])
        reference, *records = [screen_record(screen, patches.coordinates)] * (1 + len(points))
        results = {"hit_format": HitFormat.FULL}
    else:
        ceiling, down = ceiling_points(opened)
        hemisphere = Hemisphere(*rays)
        reference, *records = (hemisphere_record(hemisphere, patches.coordinates, ceiling[point], down)
                               for point in (REFERENCE, *points))
        results = {"hit_format": HitFormat.FULL, "sums": True, "weights": hemisphere.polar_weights}
    if sets:
        results["plan"] = _plan(reference, patches, table, config, sets)
    return PhaseRequest(geometry=patches, table=table, records=records, **results | given)


def shadow_phases(scene: str, config: Config, *, cell: float, count: int, seed: int) -> list[PhaseRequest]:
    """Shadow frusta of drawn rays from points of a built-in scene's light, a phase for each size of their grids."""
    patches, table = geometry(scene, config, cell)
    rays, _ = drawn_rays(open_scene(scene), count, seed, lights=2)
    by_size = defaultdict(list)
    for _, record, _ in shadow_frusta(rays, patches.coordinates):
        by_size[record.columns].append(record)
    return [PhaseRequest(geometry=patches, table=table, records=records) for records in by_size.values()]


def _plan(reference, patches, table, config, sets) -> Schedule:
    if sets == "scheduled":
        return machine_schedule(reference, patches, table, config, ratio=RATIO)
    none, nodes = np.zeros(0, dtype=np.int64), config.noc.nodes
    return Schedule(found=None, partition=Partition(reference.columns, reference.rows, ()), cluster=none,
                    processor=np.arange(nodes),
                    sets=ResidentSets(tuple(np.array(one, dtype=np.int64) for one in sets)),
                    subshells=(NO_SUBSHELLS,) * nodes)
