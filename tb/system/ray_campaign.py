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

from golden.cast.hemisphere import Hemisphere
from golden.cast.screen import Screen
from golden.engine.config import Config
from golden.engine.frustum import FrustumRecord, hemisphere_record, screen_record
from golden.engine.jobs.job import Job, PhaseRequest, plan_job
from golden.engine.jobs.result_formats import HitFormat
from golden.engine.jobs.run_job import JobResults, run_job
from golden.engine.memsys.patches.cell_table import CellTable
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.phase import schedule
from golden.scene.builtin import builtin_scene
from golden.scene.camera import Camera
from golden.scene.scene import Scene
from hw.memsys.bus.cache_policy import CachePolicy
from hw.registers.error_code import ErrorCode
from radiosity.flow.host import Host
from radiosity.flow.simulator.simulated_port import SimulatedPort, complete
from tb.golden.soups import soup
from tb.lib.configurations import config_of
from tb.system.job_differences import job_differences

__all__ = ["Campaign", "cast_campaign", "configuration"]

# Capacities for the frusta drawn; tags that seldom need a sweep; wide beats, so that hits leave at one ray per cycle.
_CHANGES = {"icu.rays": 1 << 12, "icu.side_bits": 8, "icu.patch_bits": 10, "icu.generation_bits": 8,
            "memsys.scene_cells": 1024, "memsys.own_cells": 256, "memsys.own_entries": 512, "memsys.own_patches": 64,
            "memsys.cell_lines": 16, "memsys.patch_lines": 16, "memsys.lfu_lines": 8, "memory.data_bits": 128,
            "ctu.run_ahead": 6, "ctu.shell_bits": 6, "noc.rows": 1}
# Azimuths and polars: of frusta that fill a ray memory, and of larger ones.
_HEMISPHERES = (64, 64), (128, 32), (256, 16), (128, 64), (64, 128), (256, 64)
# Frusta of a phase, and phases of a job.
_FRUSTA, _PHASES = 6, 2
# Rays for each ray of the sparse casting.
_RATIO = 16
_BASE = 0x4000
_NAMES = {code.value: code.name for code in ErrorCode}


def configuration(clusters: int) -> Config:
    """The machine's."""
    return config_of(_CHANGES | {"noc.columns": clusters})


@dataclass
class Campaign:
    """What has been cast.

    Members
    -------
    rays, cycles
        Rays, and cycles of the machine.
    differences
        What differs from golden, see `job_differences`, and in which job.
    found
        Frusta and results by what they are: hits, words of sums, hemispheres, screens.
    seconds
        Processor time: ``golden``, ``machine``.
    """

    rays: int = 0
    cycles: int = 0
    differences: list[str] = field(default_factory=list)
    found: Counter = field(default_factory=Counter)
    seconds: Counter = field(default_factory=Counter)


def _scene(draw: random.Random) -> Scene:
    kind = draw.choice(("soup", "soup", "soup", "cornell", "furnace", "tetra"))
    if kind == "soup":
        return soup(draw.getrandbits(31), draw.randrange(10, 70))
    return builtin_scene({"cornell": "cornell", "furnace": f"furnace:{draw.randrange(1, 4)}", "tetra": "tetra:1"}[kind])


def _records(draw, scene, config) -> tuple[PatchGeometry, list[FrustumRecord], np.ndarray | None]:
    """Frusta of equal sizes from points inside the scene's box; the first one is for the schedule."""
    numpy = np.random.default_rng(draw.getrandbits(63))
    lower, upper = scene.bounds
    points = numpy.uniform(lower, np.maximum(upper, lower + 1e-3 * scene.size), (_FRUSTA + 1, 3))
    geometry = PatchGeometry.of(scene, config.numbers, points)
    surfaces = [-1, *np.unique(geometry.surface).tolist()]
    if draw.random() < 0.7:
        hemisphere = Hemisphere(*draw.choice(_HEMISPHERES))
        return geometry, [hemisphere_record(
            hemisphere, geometry.coordinates, point, numpy.normal(size=3), source=draw.choice(surfaces))
            for point in points], hemisphere.polar_weights
    width, height = draw.choice(_HEMISPHERES)
    width, height, fov = width - draw.randrange(4), height - draw.randrange(4), draw.choice((20.0, 50.0, 80.0))
    cameras = [Camera(eye=tuple(point), target=tuple(point + numpy.normal(size=3)), up=tuple(numpy.normal(size=3)),
                      fov=fov) for point in points]
    return geometry, [screen_record(Screen(camera=camera, width=width, height=height), geometry.coordinates)
                      for camera in cameras], None


def _phase(draw, config) -> PhaseRequest:
    """Frusta of a drawn scene; the clusters hold its patches, those of a schedule, or none."""
    clusters, scene = config.noc.nodes, _scene(draw)
    geometry, (sparse, *records), weights = _records(draw, scene, config)
    table = CellTable(geometry.vertices, cell=geometry.coordinates.cell_size(draw.choice((1.0, 0.5, 0.25))))
    plan = draw.choice((None, schedule(
        sparse, geometry, table, config, clusters=clusters, ratio=_RATIO, capacity=config.memsys.own_patches,
        fill=draw.choice((False, True))).without_subshells()))
    return PhaseRequest(geometry=geometry, table=table, records=records, weights=weights, sums=weights is not None,
                        hit_format=draw.choice((HitFormat.FULL, HitFormat.COMPACT)),
                        clusters=draw.choice((1, clusters)), plan=plan)


def _jobs(draw: random.Random, config: Config, spent: Counter) -> Iterator[tuple[Job, JobResults]]:
    """Jobs of drawn phases, and their results by brute force."""
    while True:
        begin = time.process_time()
        phases = [_phase(draw, config) for _ in range(_PHASES)]
        job = plan_job(phases, config, base=_BASE, ring_bits=draw.choice((2, 6)))
        expected = run_job(job, brute_force=True)
        spent["golden"] += time.process_time() - begin
        yield job, expected


def cast_campaign(clusters: int, *, seed: int, rays: int, progress: bool = False) -> Campaign:
    """Cast drawn jobs until so many rays have been compared: every field of every hit, and every sum.

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
        host = Host(port, config)
        complete(host.identify())

        def read(address, size):
            return complete(port.read_memory(address, size))

        for number, (job, expected) in enumerate(_jobs(draw, config, campaign.seconds)):
            begin = time.process_time()
            port.resize(max(port.size, job.end))
            complete(host.begin(job, policy=draw.choice(tuple(CachePolicy))))
            records = complete(host.run(job, timeout=1 << 24))
            campaign.differences += [f"job {number}: {one}" for one in job_differences(expected, records, read, _NAMES)]
            _count(job, records, read, campaign)
            campaign.seconds["machine"] += time.process_time() - begin
            if campaign.rays >= rays:
                campaign.cycles = port.cycles
                assert port.outside == 0, "accesses outside main memory"
                return campaign
    raise AssertionError("jobs never end")


def _count(job, records, read, campaign):
    campaign.found["words of sums"] += int(records["sums"].sum())
    for number, phase in enumerate(job.phases):
        frusta = phase.request.records
        campaign.rays += sum(map(len, frusta))
        campaign.found["screens" if frusta[0].is_screen else "hemispheres"] += len(frusta)
        campaign.found["hits"] += sum(int((job.hits(number, frustum, read).patch >= 0).sum())
                                      for frustum in range(len(frusta)))


@click.command()
@click.option("--clusters", type=click.Choice([1, 2, 4]), default=1, show_default=True)
@click.option("--seed", default=1, show_default=True)
@click.option("--rays", default=100_000, show_default=True)
def main(clusters: int, seed: int, rays: int) -> None:
    """Cast a campaign."""
    done = cast_campaign(clusters, seed=seed, rays=rays, progress=True)
    click.echo(f"{done.rays} rays, {len(done.differences)} differences {' '.join(done.differences[:1])}")
    seconds = ", ".join(f"{name} {spent:.1f} s" for name, spent in done.seconds.items())
    click.echo(f"{dict(done.found)}; {done.cycles} cycles; processor time: {seconds}")


if __name__ == "__main__":
    main()
