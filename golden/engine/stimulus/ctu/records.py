"""Records of cell traversal in whole frusta of scenes, stage by stage, in barrier order."""

from dataclasses import dataclass

import numpy as np

from golden.cast.default_camera import default_camera
from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.engine.cast.cluster_casting import Stage
from golden.engine.cast.fixed_hits import FixedHits, read_out
from golden.engine.cast.shelling import Shelling, ShellingCounts
from golden.engine.config import Config
from golden.engine.ctu.sector import Sector
from golden.engine.frustum import FrustumRecord, hemisphere_record, screen_record
from golden.engine.icu.ray_memory import RayMemory
from golden.engine.icu.settle_code import settle_code
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.ceiling_points import ceiling_points
from golden.engine.schedule.phase import schedule
from golden.engine.schedule.subshells import SubshellList
from golden.scene.open import open_scene

__all__ = ["CELLS", "SCENES", "Played", "SectorRecord", "TraversalRecord", "traversal_record"]

SCENES, CELLS = ("cornell", "lobby", "room1627"), (0.5, 0.125, 0.0625)
# Ratio of the sparse casting that finds sections and subshells.
RATIO = 16


@dataclass(frozen=True, kw_only=True, eq=False)
class Played:
    """A stage, with the input of its survival test.

    Parameters
    ----------
    stage
        Cells opened and patches found; ``cells`` are compared with repetitions, in any order.
    threshold
        Threshold of the shell for settle codes.
    codes
        rows x columns int64: the section's settle codes at the beginning of the stage, after all earlier tests.
    """

    stage: Stage
    threshold: int
    codes: np.ndarray


@dataclass(frozen=True, kw_only=True, eq=False)
class SectorRecord:
    """One cluster's part of a frustum.

    Parameters
    ----------
    sector
        The cluster's section and sector.
    subshells
        Its subshell list; the last subshell is not listed.
    played
        The stages in order. Stages in which no ray may change are omitted.
    """

    sector: Sector
    subshells: SubshellList
    played: tuple[Played, ...]


@dataclass(frozen=True, kw_only=True, eq=False)
class TraversalRecord:
    """The record of a frustum.

    Parameters
    ----------
    shelling, record
        The scene with its cells, and the frustum.
    sectors
        The record of each cluster.
    hits
        Hits of the rays.
    """

    shelling: Shelling
    record: FrustumRecord
    sectors: tuple[SectorRecord, ...]
    hits: FixedHits


def traversal_record(scene: str, *, cell: float, config: Config, clusters: int = 1, rays: tuple[int, int] = (64, 16),
                     pixels: tuple[int, int] | None = None) -> TraversalRecord:
    """A hemisphere from the ceiling, scheduled from another point of it; or the scene's view on a screen.

    Parameters
    ----------
    scene, cell
        Name of a built-in scene, and cell size as a share of its longest side.
    clusters
        A power of two.
    rays, pixels
        Azimuths and polars; pixels across and down for the screen instead.
    """
    opened = open_scene(scene)
    points, down = ceiling_points(opened)
    camera = opened.camera or default_camera(opened)
    geometry = PatchGeometry.of(opened, config.numbers, [*points, camera.eye])
    shelling = Shelling(geometry, config, cell=cell, by_code=True)
    if pixels:
        record = sparse = screen_record(Screen(camera=camera, width=pixels[0], height=pixels[1]), geometry.coordinates)
    else:
        record, sparse = (hemisphere_record(Hemisphere(*rays), geometry.coordinates, points[point], down)
                          for point in (5, 0))
    plan = schedule(sparse, geometry, shelling.table, config, clusters=clusters, ratio=RATIO)
    if not config.ctu.subshells:
        plan = plan.without_subshells()
    memory = RayMemory(len(record), config)
    tests = shelling.tests(record, memory)
    sectors = tuple(_sector(shelling, record, sector, subshells, memory, tests, config)
                    for sector, subshells in zip(plan.partition.sections, plan.subshells, strict=True))
    return TraversalRecord(shelling=shelling, record=record, sectors=sectors,
                           hits=read_out(memory, record, tests.patches, config))


def _sector(shelling, record, sector, subshells, memory, tests, config):
    cluster, played = shelling.cluster(record, sector), []
    for stage_number in cluster.schedule(subshells, tests.window):
        seen = memory.inverse
        stage = cluster.explore(*stage_number, seen)
        if stage is not None:
            codes = settle_code(seen.reshape(record.rows, record.columns), config)
            played.append(Played(stage=stage, threshold=cluster.traversal.threshold(stage.shell, config),
                                 codes=codes[sector.first_row:sector.end_row, sector.first_column:sector.end_column]))
            tests.run(stage, sector, ShellingCounts())
    return SectorRecord(sector=sector, subshells=subshells, played=tuple(played))
