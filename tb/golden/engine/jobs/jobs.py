"""Jobs of a small scene."""

import functools

import numpy as np

from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.engine.config import PRESETS, Config
from golden.engine.frustum import hemisphere_record, screen_record
from golden.engine.jobs.job import Job, PhaseRequest, plan_job
from golden.engine.jobs.result_formats import HitFormat
from golden.scene.open import open_scene
from tb.golden.engine.schedule.scenes import Case, case

__all__ = ["CONFIG", "hemispheres", "job", "memory_with", "requests", "scene"]

# Frusta of 1,024 rays are two sections.
CONFIG: Config = PRESETS["tiny"].replace({"icu.rays": 512, "memsys.own_patches": 1024})
RAYS = Hemisphere(64, 16)
SMALL = Hemisphere(32, 8)


@functools.cache
def scene() -> Case:
    """`lobby` with cells of an eighth."""
    return case("lobby")


def hemispheres(count: int, rays: Hemisphere = RAYS) -> list:
    """Hemispheres from random points of the scene."""
    random, (lower, upper) = np.random.default_rng(count), open_scene("lobby").bounds
    return [hemisphere_record(rays, scene().geometry.coordinates, random.uniform(lower, upper), random.normal(size=3),
                              source=number % 5 - 1) for number in range(count)]


def requests() -> list[PhaseRequest]:
    """Hemispheres in two phases, and a screen."""
    geometry, table = scene().geometry, scene().shelling.table
    screen = screen_record(Screen(camera=open_scene("lobby").camera, width=30, height=19), geometry.coordinates)
    shared = {"geometry": geometry, "table": table}
    return [PhaseRequest(records=hemispheres(5), weights=RAYS.polar_weights, hit_format=HitFormat.COMPACT, sums=True,
                         cycles=[3, 1, 4, 1, 5], **shared),
            PhaseRequest(records=hemispheres(3, SMALL), weights=SMALL.polar_weights, sums=True, **shared),
            PhaseRequest(records=[screen], hit_format=HitFormat.IDS, **shared)]


@functools.cache
def job() -> Job:
    """The job of `requests`, in a ring of eight entries, not at the beginning of memory."""
    return plan_job(requests(), CONFIG, ring_bits=3, base=1000)


def memory_with(one: Job, *extents: dict[int, bytes]) -> bytearray:
    """Main memory up to the end of a job, with bytes by their addresses."""
    memory = bytearray(one.end)
    for written in extents:
        for address, data in written.items():
            memory[address:address + len(data)] = data
    return memory
