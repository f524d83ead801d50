"""Simulated machines: the cycles of one cluster, beside those of the hardware.

``radiosity bench machines`` simulates one hemisphere from each scene's ceiling on a cluster that holds all patches, and
writes out/bench/machines.md. With ``--calibrate`` it simulates what docs/figures/engine-cycles.csv, memory-cycles.csv,
cut-cycles.csv and job-cycles.csv have of the hardware, and compares. Where latencies come from,
`radiosity.machines.engine.cluster_latencies` and `radiosity.machines.engine.job_latencies` say.
"""

import csv
from itertools import chain

import click
import numpy as np

from benchmarks.engine import POINT, SCENES
from benchmarks.machine_cuts import recorded_cuts, simulated_cuts
from benchmarks.machine_jobs import recorded_jobs, simulate
from benchmarks.machine_memory import recorded_memory, simulated_memory
from benchmarks.report import output_option, provenance, table, write_report
from golden.base.errors import InputError
from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.shelling import Shelling
from golden.engine.config import PRESETS, Config
from golden.engine.frustum import hemisphere_record
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.ceiling_points import ceiling_points
from golden.scene.open import open_scene
from radiosity.cli.console import console
from radiosity.cli.parameters import ASSIGNMENTS, PRESET, WholePair
from radiosity.flow.simulator.simulation_config import simulation_config
from radiosity.flow.synthesis.history import ROOT
from radiosity.machines.engine.cluster_latencies import cluster_timing
from radiosity.machines.engine.simulated_cast import SimulatedCast, cast_section

__all__ = ["SceneCasts", "errors_of", "machine_config", "recorded_cycles"]

_RECORDED = ROOT / "docs" / "figures" / "engine-cycles.csv"
_RAYS = 256, 64
_HEAD = ["scene", "cell", "cycles", "tests", "patches", "cells", "grid rays", "efficiency"]
_CUT_HEAD = ["scene", "network", "clusters", "cell", "resident sets", "patch store", "cycles", "simulated", "error"]
_MEMORY_HEAD = ["preset", "scene", "frustum", "cell", "memory", "patch store", "cycles", "simulated", "error"]
_JOB_HEAD = ["scene", "clusters", "rays", "cell", "frusta", "hits", "cycles", "simulated", "load", "simulated load",
             "cast", "simulated cast", "error"]


def recorded_cycles() -> dict[tuple[str, float], int]:
    """Warm cycles of the hardware by scene and cell size: preset ``paper``, one cluster, 256 x 64 rays."""
    with _RECORDED.open(newline="") as file:
        return {(row["scene"], float(row["cell"])): int(row["cycles"]) for row in csv.DictReader(file)}


class SceneCasts:
    """Casts the hemisphere of a scene that `benchmarks.engine` has the hardware cast.

    Parameters
    ----------
    scene
        Its name.
    config
        A configuration of one cluster.
    rays
        Azimuths and polar angles.
    """

    def __init__(self, scene: str, config: Config, *, rays: tuple[int, int] = _RAYS):
        opened = open_scene(scene)
        points, down = ceiling_points(opened)
        self._config, self._timing = config, cluster_timing(config)
        self._geometry = PatchGeometry.of(opened, config.numbers, points[[POINT]])
        self._record = hemisphere_record(Hemisphere(*rays), self._geometry.coordinates, points[POINT], down)

    def cast(self, cell: float, *, lanes: int = 1) -> SimulatedCast:
        """The cast with cells of a size and with so many ray lanes."""
        shelling = Shelling(self._geometry, self._config, cell=cell, by_code=True)
        return cast_section(shelling, self._record, self._config, self._timing, lanes=lanes)


def machine_config(preset: str, assignments: tuple[str, ...], rays: tuple[int, int]) -> Config:
    """The configuration with which `benchmarks.engine` simulates one cluster."""
    return simulation_config(PRESETS[preset].with_parameters(assignments), clusters=1, topology="mesh",
                             given=tuple(one.partition("=")[0] for one in assignments), rays=rays[0] * rays[1])


def errors_of(rows: dict[tuple[str, float], int], config: Config) -> np.ndarray:
    """Of each scene and cell size the simulated cycles divided by the hardware's, less 1."""
    return np.array([one.times.cycles / cycles - 1 for (_, cycles), one in zip(
        rows.items(), _casts(rows, config, _RAYS), strict=True)])


def _casts(rows, config, rays):
    scene = None
    for name, cell in rows:
        if scene is None or scene[0] != name:
            scene = name, SceneCasts(name, config, rays=rays)
        yield scene[1].cast(cell)


def _row(name, cell, cast):
    return [f"`{name}`", f"{cell:g}", cast.times.cycles, cast.tests, len(cast.trace.tests), cast.cells, cast.grid_rays,
            f"{cast.tests / cast.times.cycles:.3f}"]


@click.command()
@click.argument("scenes", nargs=-1)
@output_option("machines")
@click.option("--cell", type=click.FloatRange(1 / 256, 1), multiple=True, default=(0.25, 0.0625), show_default=True,
              help="Set the cell size; may be repeated.")
@click.option("--rays", type=WholePair("AZIMUTHSxPOLARS"), default="256x64", show_default=True,
              help="Set the number of rays of the hemisphere.")
@click.option("--calibrate", is_flag=True, help="Compare with all recorded cycles of the hardware, of its cell sizes, "
              "rays and preset, and with its jobs: minutes.")
@PRESET
@ASSIGNMENTS
def main(scenes, output, cell, rays, calibrate, preset, assignments) -> None:
    """Simulate one hemisphere on one cluster; SCENES default to cornell, lobby, room1627, tetra and man."""
    recorded = recorded_cycles()
    if calibrate:
        known = tuple(dict.fromkeys(name for name, _ in recorded))
        for name in scenes:
            if name not in known:
                raise InputError(f"machines: Scenes must be of {', '.join(known)} with --calibrate, not {name!r}")
        preset, assignments, rays = "paper", (), _RAYS
        rows = [key for key in recorded if not scenes or key[0] in scenes]
    else:
        rows = [(name, one) for name in scenes or SCENES for one in cell]
    found, errors = [], {}
    for (name, one), cast in zip(rows, _casts(rows, machine_config(preset, assignments, rays), rays), strict=True):
        found.append(_row(name, one, cast))
        console().note(f"{name}, cell {one:g}: {cast.times.cycles} cycles")
        if calibrate:
            error = cast.times.cycles / recorded[name, one] - 1
            errors.setdefault(name, []).append(error)
            found[-1] += [recorded[name, one], f"{100 * error:+.1f} %"]
    lines = ["# A cluster, simulated", "",
             f"{provenance('numpy')}; preset {' '.join((preset, *assignments))}, {rays[0]} x {rays[1]} rays from point "
             f"{POINT} of the ceiling.", "", *table([*_HEAD, *["hardware", "error"] * calibrate], found)]
    if calibrate:
        errors["all"] = [*chain.from_iterable(errors.values())]
        lines += ["", *table(["scene", "rows", "mean error", "largest error"],
                             [[f"`{name}`", *_errors(each)] for name, each in errors.items() if each]), ""]
        lines += _memory(tuple(row for row in recorded_memory() if not scenes or row.scene in scenes))
        lines += _cuts(tuple(row for row in recorded_cuts() if not scenes or row.scene in scenes))
        lines += _jobs(tuple(one for one in recorded_jobs() if not scenes or one.spec.scene in scenes))
    write_report(output, lines)


def _errors(each):
    """How many, the mean, and the largest one."""
    return [len(each), f"{100 * np.abs(each).mean():.1f} %", f"{100 * max(each, key=abs):+.1f} %"]


def _memory(recorded):
    """Tables of frusta in scenes larger than a cluster's memory."""
    rows, errors = [], []
    for row, simulated in simulated_memory(recorded):
        errors.append(simulated / row.cycles - 1)
        rows.append([f"`{row.preset}`", f"`{row.scene}`", row.frustum, f"{row.cell:g}", row.latency,
                     row.store or "none", f"{row.cycles:,}", f"{simulated:,}", f"{100 * errors[-1]:+.1f} %"])
        console().note(f"{row.scene}, {row.frustum}, memory of {row.latency} cycles: {simulated} cycles")
    if not rows:
        return []
    return [*table(_MEMORY_HEAD, rows), "",
            *table(["with main memory", "mean error", "largest error"], [_errors(errors)]), ""]


def _cuts(recorded):
    """Tables of frusta that clusters share."""
    rows, errors = [], []
    for row, simulated in simulated_cuts(recorded):
        errors.append(simulated / row.cycles - 1)
        rows.append([f"`{row.scene}`", row.topology, row.clusters, f"{row.cell:g}", row.sets, row.store or "none",
                     f"{row.cycles:,}", f"{simulated:,}", f"{100 * errors[-1]:+.1f} %"])
        console().note(f"{row.scene}, one frustum, {row.clusters} clusters, {row.topology}: {simulated} cycles")
    if not rows:
        return []
    return [*table(_CUT_HEAD, rows), "",
            *table(["shared frusta", "mean error", "largest error"], [_errors(errors)]), ""]


def _jobs(jobs):
    """Tables of whole jobs."""
    rows, errors = [], []
    for recorded, job in simulate(jobs):
        spec, pairs = recorded.spec, (
            (recorded.cycles, job.times.cycles), (recorded.load, job.times.load),
            (recorded.cast, round(job.cast_cycles / recorded.clusters)))
        errors.append(job.times.cycles / recorded.cycles - 1)
        rows.append([f"`{spec.scene}`", recorded.clusters, f"{spec.rays[0]} x {spec.rays[1]}", f"{spec.cell:g}",
                     spec.frusta, spec.hit_format.name.lower(), *(f"{each:,}" for pair in pairs for each in pair),
                     f"{100 * errors[-1]:+.1f} %"])
        console().note(f"{spec.scene}, {spec.frusta} frusta, {recorded.clusters} clusters: {job.times.cycles} cycles")
    if not jobs:
        return []
    return [*table(_JOB_HEAD, rows), "", *table(["jobs", "mean error", "largest error"], [_errors(errors)])]
