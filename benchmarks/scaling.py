"""Scaling of the engine: a job on machines of 1 to 1024 clusters, simulated.

``radiosity bench scaling`` simulates a job of hemispheres on machines of several sizes, each divided into groups of 1
to 16 clusters that cast a frustum each (strong scaling), and a job of a hemisphere for each cluster (weak scaling). It
writes out/bench/scaling.md and a chart of each. Cycles of more clusters than hardware has been compared with are
extrapolated, and marked.
"""

from dataclasses import replace

import click
import numpy as np

from benchmarks.report import benchmark, cell_text, provenance, table, write_chart, write_report
from golden.engine.config import PRESETS, Config
from radiosity.charts.chart import Line
from radiosity.cli.console import console
from radiosity.machines.engine.engine_machine import EngineMachine, EngineRun
from radiosity.machines.engine.job_runs import JobSpec

__all__ = ["divisions", "row_of", "strong_runs", "weak_run"]

# Clusters, those of a group at most, and hemispheres of strong scaling.
_NODES, _LARGEST, _FRUSTA = (1, 4, 16, 64, 256, 1024), 16, 64
_HEAD = ("clusters", "groups", "cycles", "load", "casts", "longest section", "dispatch", "port", "limit", "efficiency",
         "rays per cycle", "speedup")


def divisions(nodes: int, frusta: int) -> list[int]:
    """Numbers of groups that machines of so many clusters are divided into: not more than frusta, if there may be."""
    groups = [nodes // size for size in (1 << bit for bit in range(_LARGEST.bit_length())) if size <= nodes]
    return [count for count in groups if count <= frusta] or groups[-1:]


def strong_runs(machine: EngineMachine, nodes: int, frusta: int) -> list[EngineRun]:
    """The runs of all divisions of so many clusters, the fastest one first."""
    return sorted((machine.run(nodes, groups) for groups in divisions(nodes, frusta)), key=lambda run: run.cycles)


def weak_run(spec: JobSpec, config: Config, nodes: int) -> EngineRun:
    """A job of as many frusta as clusters."""
    return EngineMachine(replace(spec, frusta=nodes), config).run(nodes, nodes)


def row_of(run: EngineRun, first: EngineRun) -> list:
    """A row of the tables; the speedup is that of rays per cycle over those of the first run."""
    bounds = run.bounds
    speedup = run.rays / run.cycles * first.cycles / first.rays
    return [f"{run.nodes}{' *' if run.is_extrapolated else ''}", run.groups, f"{run.cycles:,}",
            *(f"{bounds[name]:,}" for name in ("load", "casts", "longest section", "dispatch", "port")), run.bound,
            f"{run.efficiency:.3f}", f"{run.rays / run.cycles:.3f}", f"{speedup:.2f}"]


def _chart(name: str, runs: list[EngineRun], title: str) -> None:
    nodes = np.array([run.nodes for run in runs])
    rates = np.array([run.rays / run.cycles for run in runs])
    write_chart(
        name, [Line(name="simulated", x=nodes, y=rates),
               Line(name="linear", x=np.array([0, nodes[-1]]), y=np.array([0, rates[0] / nodes[0] * nodes[-1]]))],
        title=title, x_name="clusters (extrapolated above 16)", y_name="rays per cycle",
        y_top=1.1 * float(rates.max()))


@benchmark("scaling")
@click.argument("scene", default="lobby")
def main(scene) -> None:
    """Simulate jobs in SCENE on machines of several sizes."""
    config, spec = PRESETS["paper"], JobSpec(scene=scene, frusta=_FRUSTA)
    machine, strong, weak = EngineMachine(spec, config), [], []
    for count in _NODES:
        strong.append(strong_runs(machine, count, _FRUSTA))
        console().note(f"{_FRUSTA} frusta, {count} clusters: {strong[-1][0].cycles} cycles")
    for count in _NODES:
        weak.append(weak_run(replace(spec, cell=strong[0][0].prepared.cell), config, count))
        console().note(f"{count} frusta, {count} clusters: {weak[-1].cycles} cycles")
    rays = f"{spec.rays[0]} x {spec.rays[1]} rays"
    _chart(f"scaling-{scene}-strong", [runs[0] for runs in strong], f"{scene}: {_FRUSTA} hemispheres of {rays}")
    _chart(f"scaling-{scene}-weak", weak, f"{scene}: a hemisphere of {rays} for each cluster")
    write_report(
        "Scaling of the engine, simulated",
        f"{provenance('numpy')}; preset paper, `{scene}`, hemispheres of {rays} from points of the ceiling, "
        f"{cell_text(None)}, sums written, main memory 10 cycles away. "
        "* extrapolated: hardware of so many clusters has not been simulated.",
        f"{_FRUSTA} hemispheres, each number of clusters divided into groups, the fastest division first:",
        table(_HEAD, [row_of(run, strong[0][0]) for runs in strong for run in runs]),
        "A hemisphere for each cluster:",
        table(_HEAD, [row_of(run, weak[0]) for run in weak]))
