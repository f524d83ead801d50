"""The view into a built-in scene that the board casts."""

from dataclasses import dataclass

from golden.cast.shelling import Shelling
from golden.config import PRESETS, Config
from golden.errors import InputError
from golden.frustum import FrustumRecord, Screen, screen_record
from golden.jobs.job import Job, PhaseRequest, plan_job
from golden.jobs.result_formats import HitFormat
from golden.jobs.tile_sections import tile_sections
from golden.scene.open import open_scene
from golden.scene.patch_geometry import PatchGeometry
from golden.scene.view import default_camera
from golden.schedule.phase import schedule
from hw.board.narrow import NARROW

__all__ = ["BOARD", "View", "board_view"]

# One cluster for a small scene with minimal capacities and narrow numbers: those of the preset need more registers than
# nextpnr's default placer can place.
BOARD = PRESETS["tiny"].replace(NARROW | {
    "icu.uv_bits": 4, "icu.uv_guard": 4, "icu.side_bits": 6, "icu.patch_bits": 8, "ctu.shell_bits": 4,
    "ctu.grid_row_bits": 7, "ctu.grid_column_bits": 7, "ctu.near_cell_bits": 5,
    "memsys.cell_lines": 16, "memsys.patch_lines": 16, "memsys.cache_fetches": 2,
    "memsys.scene_cells": 128, "memsys.own_cells": 128, "memsys.own_entries": 256, "memsys.own_patches": 32,
    "memsys.bus_requests": 2, "memory.address_bits": 20, "memory.outstanding": 4})
# Rays for each one of the low-density casting, by which the job is scheduled.
RATIO = 16


@dataclass(frozen=True, kw_only=True, eq=False)
class View:
    """A view: the job that casts it, and its rays and patches.

    Parameters
    ----------
    job
        A load and the sections of the view, in rings with an entry for each of them.
    record, geometry
        Rays and patches.
    """

    job: Job
    record: FrustumRecord
    geometry: PatchGeometry


def board_view(config: Config, *, scene: str, pixels: tuple[int, int], cell: float) -> View:
    """The view into a scene.

    Parameters
    ----------
    config
        The configuration.
    scene, pixels, cell
        Name of a built-in scene, pixels across and down, and cell size as a share of the scene's longest side.

    Raises
    ------
    InputError
        There is no such scene, or the configuration has more than one cluster or too little capacity for the scene.
    """
    if config.noc.nodes != 1:
        raise InputError(f"board: Clusters (noc.columns, noc.rows) must be 1, not {config.noc.nodes}")
    opened = open_scene(scene)
    camera = opened.camera or default_camera(opened)
    geometry = PatchGeometry.of(opened, config.numbers, [camera.eye])
    table = Shelling(geometry, config, cell=cell, by_code=True).table
    record = screen_record(Screen(camera=camera, width=pixels[0], height=pixels[1]), geometry.coordinates)
    plan = schedule(record, geometry, table, config, clusters=1, ratio=RATIO, capacity=config.memsys.own_patches)
    if not config.ctu.subshells:
        plan = plan.without_subshells()
    sections = len(tile_sections(record.columns, record.rows, config, clusters=1))
    phase = PhaseRequest(geometry=geometry, table=table, records=[record], hit_format=HitFormat.FULL, plan=plan)
    return View(job=plan_job([phase], config, ring_bits=sections.bit_length()), record=record, geometry=geometry)
