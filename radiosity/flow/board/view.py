"""The view into a built-in scene that the board casts."""

from dataclasses import dataclass

from golden.cast.default_camera import default_camera
from golden.cast.screen import Screen
from golden.engine.cast.shelling import Shelling
from golden.engine.config import Config
from golden.engine.frustum import FrustumRecord, screen_record
from golden.engine.jobs.job import Job, PhaseRequest, plan_job
from golden.engine.jobs.result_formats import HitFormat
from golden.engine.jobs.tile_sections import tile_sections
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.scene.open import open_scene

__all__ = ["View", "board_view"]

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
        There is no such scene, or the configuration has too little capacity for it or for the view.
    """
    opened = open_scene(scene)
    camera = opened.camera or default_camera(opened)
    geometry = PatchGeometry.of(opened, config.numbers, [camera.eye])
    table = Shelling(geometry, config, cell=cell, by_code=True).table
    record = screen_record(Screen(camera=camera, width=pixels[0], height=pixels[1]), geometry.coordinates)
    clusters = config.noc.clusters
    sections = len(tile_sections(record.columns, record.rows, config, clusters=clusters))
    phase = PhaseRequest(geometry=geometry, table=table, records=[record], hit_format=HitFormat.FULL, clusters=clusters)
    return View(job=plan_job([phase], config, ring_bits=sections.bit_length()), record=record, geometry=geometry)
