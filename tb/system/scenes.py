"""Whole frusta for the machine: the image that it is given, and what it must write."""

import shutil
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from golden.cast.fixed_hits import FixedHits
from golden.cast.naive_fixed import NaiveFixed
from golden.cast.shelling import Shelling
from golden.config import Config
from golden.frustum import Hemisphere, Screen, hemisphere_record, screen_record
from golden.memory_map import MemoryImage, from_bytes, machine_image
from golden.scene.open import open_scene
from golden.scene.patch_geometry import PatchGeometry
from golden.scene.view import default_camera
from golden.schedule.ceiling_points import ceiling_points
from golden.schedule.phase import schedule

__all__ = ["Frustum", "frusta", "load", "save"]

# Of the sparse casting that finds sections and subshells.
RATIO = 16


@dataclass(frozen=True, kw_only=True, eq=False)
class Frustum:
    """A frustum of a phase.

    Parameters
    ----------
    image
        Before the machine.
    hits
        Brute force's.
    total
        What the weights add up to; 0 of a screen.
    """

    image: MemoryImage
    hits: FixedHits
    total: int

    @property
    def written(self) -> MemoryImage:
        """The image as the machine must leave it."""
        return self.image.with_results(self.hits)


def frusta(scene: str, config: Config, *, cell: float, rays: tuple[int, int] = (32, 8), points=(5,),
           pixels: tuple[int, int] | None = None) -> list[Frustum]:
    """Hemispheres from the ceiling, all of one phase that is scheduled from another point of it; or a screen.

    Parameters
    ----------
    scene, cell
        Name of a built-in scene, and cell size as a share of its longest side.
    rays
        Azimuths and polars.
    points
        Which of `ceiling_points`.
    pixels
        Across and down: the scene's view instead.
    """
    opened = open_scene(scene)
    ceiling, down = ceiling_points(opened)
    camera = opened.camera or default_camera(opened)
    geometry = PatchGeometry.of(opened, config.numbers, [*ceiling, camera.eye])
    table, brute_force = Shelling(geometry, config, cell=cell, by_code=True).table, NaiveFixed(geometry, config)
    weights = None
    if pixels:
        screen = Screen(camera=camera, width=pixels[0], height=pixels[1])
        sparse, *records = [screen_record(screen, geometry.coordinates)] * 2
    else:
        hemisphere = Hemisphere(*rays)
        weights = hemisphere.polar_weights
        sparse, *records = (hemisphere_record(hemisphere, geometry.coordinates, ceiling[point], down)
                            for point in (0, *points))
    plan = schedule(sparse, geometry, table, config, clusters=config.noc.nodes, ratio=RATIO,
                    ray_capacity=config.icu.rays, capacity=config.memsys.own_patches)
    if not config.ctu.subshells:
        plan = plan.without_subshells()
    return [Frustum(image=machine_image(record, geometry, table, config, plan, weights=weights),
                    hits=brute_force.cast(record), total=0 if weights is None else int(weights.sum()) * record.columns)
            for record in records]


def save(given: list[Frustum], folder: Path) -> Path:
    """Into files that `load` reads."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    for number, one in enumerate(given):
        (folder / f"{number}.bin").write_bytes(one.image.to_bytes())
        np.savez(folder / f"{number}.npz", total=one.total, **{
            name: getattr(one.hits, name) for name in ("inverse", "patch", "u", "v")})
    return folder.resolve()


def load(folder: Path) -> list[Frustum]:
    """What `save` has written."""
    found = []
    for path in sorted(folder.glob("*.bin")):
        with np.load(path.with_suffix(".npz")) as arrays:
            hits = FixedHits(**{name: arrays[name] for name in ("inverse", "patch", "u", "v")})
            found.append(Frustum(image=from_bytes(path.read_bytes()), hits=hits, total=int(arrays["total"])))
    return found
