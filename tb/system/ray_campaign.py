"""Drawn frusta on the simulated engine against brute force in fixed point, ray by ray.

``python -m tb.system.ray_campaign --clusters 2 --seed 7 --rays 100000`` casts a campaign, or again one that has failed.
`tb/system/test_ray_campaign.py` casts those of the nightly.
"""

import random
import time
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass, field

import click
import numpy as np

from golden.cast.naive_fixed import NaiveFixed
from golden.config import Config
from golden.frustum import FrustumRecord, Hemisphere, Screen, hemisphere_record, screen_record
from golden.memory_map import machine_image
from golden.memsys.cell_table import CellTable
from golden.scene import Scene
from golden.scene.builtin import builtin_scene
from golden.scene.camera import Camera
from golden.scene.patch_geometry import PatchGeometry
from golden.schedule.phase import schedule
from hw.host import LIVES, Host
from hw.memsys.cache_policy import CachePolicy
from hw.simulator.simulated_port import SimulatedPort, complete
from tb.golden.soups import soup
from tb.lib.configurations import config_of
from tb.system.scenes import Frustum

__all__ = ["Campaign", "cast_campaign", "configuration"]

# Capacities for the frusta drawn; tags that seldom need a sweep; wide beats, so that hits leave at one ray per cycle.
_CHANGES = {"icu.rays": 1 << 12, "icu.side_bits": 8, "icu.patch_bits": 10, "icu.generation_bits": 8,
            "memsys.scene_cells": 1024, "memsys.own_cells": 256, "memsys.own_entries": 512, "memsys.own_patches": 64,
            "memsys.cell_lines": 16, "memsys.patch_lines": 16, "memsys.lfu_lines": 8, "memory.data_bits": 128,
            "ctu.run_ahead": 6, "ctu.shell_bits": 6, "noc.rows": 1}
# Azimuths and polars that fill the ray memories of so many clusters.
_HEMISPHERES = {1: ((64, 64), (128, 32), (256, 16)), 2: ((128, 64), (256, 32), (64, 128)),
                4: ((128, 128), (256, 64))}
# Frusta of a phase.
_FRUSTA = 6
# Rays for each ray of the sparse casting.
_RATIO = 16
_BASE = 0x4000


def configuration(clusters: int) -> Config:
    """The machine's."""
    return config_of(_CHANGES | {"noc.columns": clusters})


@dataclass
class Campaign:
    """What has been cast.

    Members
    -------
    rays, cycles, differences
        Rays, cycles of the machine from the first load to the last result, and rays or sums that differ.
    found
        Rays and frusta by what they are: hits, hemispheres, screens.
    seconds
        Processor time: ``golden``, ``machine``.
    first
        What differs first.
    """

    rays: int = 0
    cycles: int = 0
    differences: int = 0
    found: Counter = field(default_factory=Counter)
    seconds: Counter = field(default_factory=Counter)
    first: str = ""


def _scene(draw: random.Random) -> Scene:
    kind = draw.choice(("soup", "soup", "soup", "cornell", "furnace", "tetra"))
    if kind == "soup":
        return soup(draw.getrandbits(31), draw.randrange(10, 70))
    return builtin_scene({"cornell": "cornell", "furnace": f"furnace:{draw.randrange(1, 4)}", "tetra": "tetra:1"}[kind])


def _records(draw, scene, clusters, config) -> tuple[PatchGeometry, list[FrustumRecord], np.ndarray | None]:
    """Frusta of equal sizes from points inside the scene's box; the first one is for the schedule."""
    numpy = np.random.default_rng(draw.getrandbits(63))
    lower, upper = scene.bounds
    points = numpy.uniform(lower, np.maximum(upper, lower + 1e-3 * scene.size), (_FRUSTA + 1, 3))
    geometry = PatchGeometry.of(scene, config.numbers, points)
    surfaces = [-1, *np.unique(geometry.surface).tolist()]
    if draw.random() < 0.7:
        hemisphere = Hemisphere(*draw.choice(_HEMISPHERES[clusters]))
        return geometry, [hemisphere_record(
            hemisphere, geometry.coordinates, point, numpy.normal(size=3), source=draw.choice(surfaces))
            for point in points], hemisphere.polar_weights
    # Sections at any position cut tiles, so that they need more of the ray memory than they have rays.
    width, height = draw.choice(_HEMISPHERES[clusters])
    width, height = 3 * width // 4 - draw.randrange(4), height - draw.randrange(4)
    cameras = [Camera(eye=tuple(point), target=tuple(point + numpy.normal(size=3)), up=tuple(numpy.normal(size=3)),
                      fov=draw.choice((20.0, 50.0, 80.0))) for point in points]
    return geometry, [screen_record(Screen(camera=camera, width=width, height=height), geometry.coordinates)
                      for camera in cameras], None


def _phases(draw: random.Random, clusters: int, config: Config, spent: Counter) -> Iterator[list[Frustum]]:
    """Frusta of drawn scenes, phase by phase."""
    while True:
        begin = time.process_time()
        scene = _scene(draw)
        geometry, (sparse, *records), weights = _records(draw, scene, clusters, config)
        table = CellTable(geometry.vertices, cell=geometry.coordinates.cell_size(draw.choice((1.0, 0.5, 0.25))))
        capacity = config.icu.rays if weights is not None else config.icu.rays * 13 // 16
        plan = schedule(sparse, geometry, table, config, clusters=clusters, ratio=_RATIO, ray_capacity=capacity,
                        capacity=config.memsys.own_patches, fill=draw.choice((False, True))).without_subshells()
        brute_force = NaiveFixed(geometry, config.replace({"icu.rays": clusters * config.icu.rays}))
        made = [Frustum(image=machine_image(record, geometry, table, config, plan, weights=weights),
                        hits=brute_force.cast(record),
                        total=0 if weights is None else int(weights.sum()) * record.columns)
                for record in records]
        spent["golden"] += time.process_time() - begin
        yield made


def cast_campaign(clusters: int, *, seed: int, rays: int, progress: bool = False) -> Campaign:
    """Cast drawn frusta until so many rays have been compared: every field of every hit, and every sum.

    Results of a frustum are written while the next one is cast.

    Parameters
    ----------
    clusters
        Clusters of the machine: 1, 2 or 4.
    seed
        Of all that is drawn.
    rays
        Fewest rays.
    progress
        Show the progress of a build.

    Raises
    ------
    AssertionError
        The machine accessed bytes outside main memory.
    """
    config, draw, campaign = configuration(clusters), random.Random(f"{clusters} {seed}"), Campaign()
    memory = {"latency": draw.choice((2, 10, 25)), "spread": draw.choice((0, 8)), "seed": draw.getrandbits(20)}
    with SimulatedPort(config, size=0, progress=progress, **memory) as port:
        host = Host(port, config, base=_BASE)
        complete(host.identify())
        for number, frusta in enumerate(_phases(draw, clusters, config, campaign.seconds)):
            begin = time.process_time()
            image_bytes = max(len(one.image.to_bytes()) for one in frusta)
            if _BASE + 2 * image_bytes > port.size:
                port.resize(_BASE + 2 * image_bytes)
            policy = draw.choice(tuple(CachePolicy))
            _cast_phase(port, host, frusta, image_bytes, policy, campaign, f"phase {number}")
            campaign.seconds["machine"] += time.process_time() - begin
            if campaign.rays >= rays:
                campaign.cycles = port.cycles
                assert port.outside == 0, "accesses outside main memory"
                return campaign
    raise AssertionError("phases never end")


def _cast_phase(port, host, frusta, image_bytes, policy, campaign, name):
    """All frusta of a phase; each one's results are compared while the machine casts the next one."""
    for number, frustum in enumerate(frusta):
        complete(host.load(frustum.image, lives=("rays", "frustum") if number else tuple(LIVES), policy=policy,
                           base=_BASE + number % 2 * image_bytes))
        complete(host.start())
        if number:
            _compare(host, frusta[number - 1], campaign, f"{name}, frustum {number - 1}", earlier=True)
        complete(host.finish("casts", timeout=1 << 24))
    _compare(host, frusta[-1], campaign, f"{name}, frustum {len(frusta) - 1}")


def _compare(host, frustum, campaign, name, **given):
    image, expected = complete(host.results(total=frustum.total, **given)), frustum.written
    rays = np.flatnonzero(image["hits"] != expected["hits"])
    sums = np.flatnonzero(image["sums"] != expected["sums"])
    if (len(rays) or len(sums)) and not campaign.first:
        campaign.first = f"{name}: rays {rays[:5].tolist()}, sums {sums[:5].tolist()}"
    campaign.differences += len(rays) + len(sums)
    campaign.rays += len(expected["hits"])
    campaign.found.update(hits=int((frustum.hits.patch >= 0).sum()), sums=len(expected["sums"]),
                          **{"screens" if frustum.image["frustum"]["is_screen"][0] else "hemispheres": 1})


@click.command()
@click.option("--clusters", type=click.Choice([1, 2, 4]), default=1, show_default=True)
@click.option("--seed", default=1, show_default=True)
@click.option("--rays", default=100_000, show_default=True)
def main(clusters: int, seed: int, rays: int) -> None:
    """Cast a campaign."""
    done = cast_campaign(clusters, seed=seed, rays=rays, progress=True)
    click.echo(f"{done.rays} rays, {done.differences} differences {done.first}")
    seconds = ", ".join(f"{name} {spent:.1f} s" for name, spent in done.seconds.items())
    click.echo(f"{dict(done.found)}; {done.cycles} cycles; processor time: {seconds}")


if __name__ == "__main__":
    main()
