"""Scaling of the engine: a job on machines of 1 to 1024 clusters, simulated.

``radiosity bench scaling`` simulates a job of hemispheres on machines of several sizes, each divided into groups of 1
to 16 clusters that cast a frustum each (strong scaling), and a job of a hemisphere for each cluster (weak scaling). It
writes out/bench/scaling.md and a chart of each. Cycles of more clusters than hardware has been compared with are
extrapolated, and marked.
"""

from dataclasses import replace
from pathlib import Path

import click
import numpy as np

from benchmarks.report import cell_text, output_option, provenance, table, write_report
from golden.engine.config import PRESETS, Config
from radiosity.charts.chart import Line, line_figure, write_figure
from radiosity.cli.console import console
from radiosity.cli.parameters import ASSIGNMENTS, METHOD_CELL, PRESET, WholePair
from radiosity.machines.engine.engine_machine import EngineMachine, EngineRun
from radiosity.machines.engine.job_runs import JobSpec

__all__ = ["divisions", "row_of", "strong_runs", "weak_run"]

# Clusters of a group, at most.
_LARGEST = 16
_HEAD = ("clusters", "groups", "cycles", "load", "casts", "longest section", "dispatch", "port", "limit", "efficiency",
         "rays per cycle", "speedup")


def divisions(nodes: int, frusta: int) -> list[int]:
    """Numbers of groups that machines of so many clusters are divided into: not more than frusta, if there may be."""
    groups = [nodes // size for size in (1 << bit for bit in range(_LARGEST.bit_length())) if size <= nodes]
    return [count for count in groups if count <= frusta] or groups[-1:]


def strong_runs(machine: EngineMachine, nodes: int, frusta: int) -> list[EngineRun]:
    """The runs of all divisions of so many clusters, the fastest one first."""
    return sorted((machine.run(nodes, groups) for groups in divisions(nodes, frusta)), key=lambda run: run.cycles)


def weak_run(spec: JobSpec, config: Config, nodes: int, **options) -> EngineRun:
    """A job of as many frusta as clusters."""
    return EngineMachine(replace(spec, frusta=nodes), config, **options).run(nodes, nodes)


def row_of(run: EngineRun, first: EngineRun) -> list:
    """A row of the tables; the speedup is that of rays per cycle over those of the first run."""
    bounds = run.bounds
    speedup = run.rays / run.cycles * first.cycles / first.rays
    return [f"{run.nodes}{' *' if run.is_extrapolated else ''}", run.groups, f"{run.cycles:,}",
            *(f"{bounds[name]:,}" for name in ("load", "casts", "longest section", "dispatch", "port")), run.bound,
            f"{run.efficiency:.3f}", f"{run.rays / run.cycles:.3f}", f"{speedup:.2f}"]


def _chart(path: Path, runs: list[EngineRun], title: str) -> None:
    nodes = np.array([run.nodes for run in runs])
    rates = np.array([run.rays / run.cycles for run in runs])
    write_figure(path, line_figure(
        [Line(name="simulated", x=nodes, y=rates),
         Line(name="linear", x=np.array([0, nodes[-1]]), y=np.array([0, rates[0] / nodes[0] * nodes[-1]]))],
        title=title, x_name="clusters (extrapolated above 16)", y_name="rays per cycle",
        y_top=1.1 * float(rates.max())))


@click.command()
@click.argument("scene", default="lobby")
@output_option("scaling")
@click.option("--nodes", type=click.IntRange(1), multiple=True, default=(1, 4, 16, 64, 256, 1024), show_default=True,
              help="Simulate this many clusters; may be repeated.")
@click.option("--frusta", type=click.IntRange(1), default=64, show_default=True, help="Cast this many hemispheres for "
              "strong scaling.")
@click.option("--rays", type=WholePair("AZIMUTHSxPOLARS"), default="256x64", show_default=True,
              help="Set the number of rays of each hemisphere.")
@METHOD_CELL
@click.option("--casts", type=click.Path(file_okay=False, path_type=Path), help="Keep the casts in this folder.")
@PRESET
@ASSIGNMENTS
def main(scene, output, nodes, frusta, rays, cell, casts, preset, assignments) -> None:
    """Simulate jobs in SCENE on machines of several sizes."""
    config, counts = PRESETS[preset].with_parameters(assignments), sorted({*nodes})
    options = {"folder": casts, "given": tuple(one.partition("=")[0] for one in assignments)}
    spec = JobSpec(scene=scene, rays=rays, frusta=frusta, cell=cell)
    machine, strong, weak = EngineMachine(spec, config, **options), [], []
    for count in counts:
        strong.append(strong_runs(machine, count, frusta))
        console().note(f"{frusta} frusta, {count} clusters: {strong[-1][0].cycles} cycles")
    for count in counts:
        weak.append(weak_run(replace(spec, cell=strong[0][0].prepared.cell), config, count, **options))
        console().note(f"{count} frusta, {count} clusters: {weak[-1].cycles} cycles")
    _chart(output.parent / f"scaling-{scene}-strong.svg", [runs[0] for runs in strong],
           f"{scene}: {frusta} hemispheres of {rays[0]} x {rays[1]} rays")
    _chart(output.parent / f"scaling-{scene}-weak.svg", weak,
           f"{scene}: a hemisphere of {rays[0]} x {rays[1]} rays for each cluster")
    write_report(output, [
        "# Scaling of the engine, simulated", "",
        f"{provenance('numpy')}; preset {' '.join((preset, *assignments))}, `{scene}`, hemispheres of {rays[0]} x "
        f"{rays[1]} rays from points of the ceiling, {cell_text(cell)}, sums written, main memory 10 cycles away. "
        "* extrapolated: hardware of so many clusters has not been simulated.", "",
        f"{frusta} hemispheres, each number of clusters divided into groups, the fastest division first:", "",
        *table(list(_HEAD), [row_of(run, strong[0][0]) for runs in strong for run in runs]), "",
        "A hemisphere for each cluster:", "",
        *table(list(_HEAD), [row_of(run, weak[0]) for run in weak])])
