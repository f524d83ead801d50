"""Simulated machines: the cycles of one cluster, beside those of the hardware.

``radiosity bench machines`` simulates one hemisphere from each scene's ceiling on a cluster that holds all patches, and
writes out/bench/machines.md. With ``--calibrate`` it simulates what docs/figures/engine-cycles.csv, memory-cycles.csv,
cut-cycles.csv and job-cycles.csv have of the hardware, and compares. Where latencies come from,
`radiosity.machines.engine.cluster_latencies` and `radiosity.machines.engine.job_latencies` say.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import chain

import click
import numpy as np

from benchmarks.ceiling import HEMISPHERE, Ceiling
from benchmarks.engine import POINT, SCENES, machine_config
from benchmarks.grades import signed
from benchmarks.machine_cuts import recorded_cuts, simulated_cuts
from benchmarks.machine_jobs import recorded_jobs, simulate
from benchmarks.machine_memory import recorded_memory, simulated_memory
from benchmarks.recorded import check_recorded, read_rows
from benchmarks.report import benchmark, provenance, table, write_report
from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.shelling import Shelling
from golden.engine.config import Config
from radiosity.cli.console import console
from radiosity.machines.engine.cluster_latencies import cluster_timing
from radiosity.machines.engine.simulated_cast import SimulatedCast, cast_section

__all__ = ["SceneCasts", "errors_of", "recorded_cycles"]

# Cells of a simulation without comparison.
_CELLS = 0.25, 0.0625
_RAYS = HEMISPHERE.azimuths, HEMISPHERE.polars


@dataclass(frozen=True)
class _Warm:
    """A row of docs/figures/engine-cycles.csv."""

    scene: str
    cell: float
    cycles: int


def recorded_cycles() -> dict[tuple[str, float], int]:
    """Warm cycles of the hardware by scene and cell size: preset ``paper``, one cluster, 256 x 64 rays."""
    return {(row.scene, row.cell): row.cycles for row in read_rows("engine-cycles", _Warm)}


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
        self._config, self._timing = config, cluster_timing(config)
        self._ceiling = Ceiling(scene, config, hemisphere=Hemisphere(*rays), point=POINT)

    def cast(self, cell: float, *, lanes: int = 1) -> SimulatedCast:
        """The cast with cells of a size and with so many ray lanes."""
        shelling = Shelling(self._ceiling.geometry, self._config, cell=cell, by_code=True)
        return cast_section(shelling, self._ceiling.record(), self._config, self._timing, lanes=lanes)


def errors_of(rows: dict[tuple[str, float], int], config: Config) -> np.ndarray:
    """Of each scene and cell size the simulated cycles divided by the hardware's, less 1."""
    return np.array([one.times.cycles / cycles - 1 for (_, cycles), one in zip(
        rows.items(), _casts(rows, config), strict=True)])


def _casts(rows: Iterable[tuple[str, float]], config: Config) -> Iterator[SimulatedCast]:
    scene = None
    for name, cell in rows:
        if scene is None or scene[0] != name:
            scene = name, SceneCasts(name, config)
        yield scene[1].cast(cell)


def _errors(each: list[float]) -> list:
    """How many, the mean, and the largest one."""
    return [len(each), f"{100 * np.abs(each).mean():.1f} %", signed(max(each, key=abs))]


def _compared(name: str, head: list[str], found: Iterable[tuple[list, int, int]]) -> list[list[str]]:
    """Tables of rows, each with its cycles of the hardware and of the simulation, and of their errors."""
    rows, errors = [], []
    for row, cycles, simulated in found:
        errors.append(simulated / cycles - 1)
        rows.append([*row, signed(errors[-1])])
        console().note(" ".join(map(str, rows[-1])))
    if not rows:
        return []
    return [table([*head, "error"], rows), table([name, "mean error", "largest error"], [_errors(errors)])]


def _calibrations(scenes: tuple[str, ...]) -> Iterator[list[list[str]]]:
    """Tables of frusta with main memory, of those that clusters share, and of jobs, in some scenes or in all."""
    def chosen(rows, scene=lambda row: row.scene):
        return tuple(row for row in rows if not scenes or scene(row) in scenes)

    yield _compared(
        "with main memory", ["preset", "scene", "frustum", "cell", "memory", "patch store", "cycles", "simulated"],
        (([f"`{row.preset}`", f"`{row.scene}`", row.frustum, f"{row.cell:g}", row.latency, row.store or "none",
           f"{row.cycles:,}", f"{cycles:,}"], row.cycles, cycles)
         for row, cycles in simulated_memory(chosen(recorded_memory()))))
    yield _compared(
        "shared frusta",
        ["scene", "network", "clusters", "cell", "resident sets", "patch store", "cycles", "simulated"],
        (([f"`{row.scene}`", row.topology, row.clusters, f"{row.cell:g}", row.sets, row.store or "none",
           f"{row.cycles:,}", f"{cycles:,}"], row.cycles, cycles)
         for row, cycles in simulated_cuts(chosen(recorded_cuts()))))
    yield _compared(
        "jobs", ["scene", "clusters", "rays", "cell", "frusta", "hits", "cycles", "simulated", "load", "simulated load",
                 "cast", "simulated cast"],
        (([f"`{one.spec.scene}`", one.clusters, f"{one.spec.rays[0]} x {one.spec.rays[1]}", f"{one.spec.cell:g}",
           one.spec.frusta, one.spec.hit_format.name.lower(), f"{one.cycles:,}", f"{job.times.cycles:,}",
           f"{one.load:,}", f"{job.times.load:,}", f"{one.cast:,}", f"{round(job.cast_cycles / one.clusters):,}"],
          one.cycles, job.times.cycles)
         for one, job in simulate(chosen(recorded_jobs(), lambda one: one.spec.scene))))


@benchmark("machines")
@click.argument("scenes", nargs=-1)
@click.option("--calibrate", is_flag=True, help="Compare with all recorded cycles of the hardware, of its cell sizes, "
              "and with its jobs: minutes.")
def main(scenes, calibrate) -> None:
    """Simulate one hemisphere on one cluster; SCENES default to cornell, lobby, room1627, tetra and man."""
    recorded = recorded_cycles()
    if calibrate:
        check_recorded("machines", scenes, [name for name, _ in recorded])
        rows = [key for key in recorded if not scenes or key[0] in scenes]
    else:
        rows = [(name, one) for name in scenes or SCENES for one in _CELLS]
    found, errors = [], {}
    for (name, one), cast in zip(rows, _casts(rows, machine_config("paper", (), _RAYS)), strict=True):
        found.append([f"`{name}`", f"{one:g}", cast.times.cycles, cast.tests, len(cast.trace.tests), cast.cells,
                      cast.grid_rays, f"{cast.tests / cast.times.cycles:.3f}"])
        console().note(f"{name}, cell {one:g}: {cast.times.cycles} cycles")
        if calibrate:
            error = cast.times.cycles / recorded[name, one] - 1
            errors.setdefault(name, []).append(error)
            found[-1] += [recorded[name, one], signed(error)]
    parts = [table(["scene", "cell", "cycles", "tests", "patches", "cells", "grid rays", "efficiency",
                    *["hardware", "error"] * calibrate], found)]
    if calibrate:
        errors["all"] = [*chain.from_iterable(errors.values())]
        parts += [table(["scene", "rows", "mean error", "largest error"],
                        [[f"`{name}`", *_errors(each)] for name, each in errors.items() if each]),
                  *chain.from_iterable(_calibrations(scenes))]
    write_report(
        "A cluster, simulated",
        f"{provenance('numpy')}; preset paper, {_RAYS[0]} x {_RAYS[1]} rays from point {POINT} of the ceiling.", *parts)
