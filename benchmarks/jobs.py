"""Whole jobs on the machine: cycles from the first load to the last result, speedup, and lower bounds.

``radiosity bench jobs`` casts hemispheres from points of each scene's ceiling in one job, on one cluster and on
several. It writes out/bench/jobs.md, and for each scene a roofline and the activity of the clusters. Results of small
jobs are compared with the golden model's, those of large ones with ``--check``.
"""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import click
import numpy as np

from benchmarks.engine import CASTS, POINT, RAYS, SCENES, machine_config
from benchmarks.report import benchmark, cell_text, page_path, provenance, table, versions, write_report
from golden.engine.config import Config
from golden.engine.jobs.result_formats import HitFormat
from radiosity.charts.chart import COLOURS, Bars, Line, lane_figure, line_figure, write_figure
from radiosity.cli.console import console
from radiosity.cli.parameters import ASSIGNMENTS, METHOD_CELL, PRESET
from radiosity.flow.simulator.verilator import verilator_version
from radiosity.machines.engine.job_runs import JobRun, JobSpec, job_machine, prepare_job, run_on

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["CHECKED", "SceneRuns", "activity_figure", "measure", "rows_of", "write_roofline"]

# Rays of the largest job that is always compared with the golden model's.
CHECKED = 1 << 17
# Presets whose network is the machine's own.
WHOLE = ("thesis",)
FORMATS = {one.name.lower(): one for one in HitFormat}
HEAD = ("scene", "clusters", "cell", "cycles", "a frustum", "load", "cast", "tests", "patches", "memory",
        "bound : cycles", "efficiency", "speedup", "rays per cycle")
CYCLES_HEAD = ("scene", "clusters", "cycles", "load", "cast", "waits", "last results", "idle")
MEAN_HEAD = ("scene", "cell", "rays", "patches", f"point {POINT}, warm", "mean of the job", "ratio", "tests per ray")


class SceneRuns:
    """A scene's job on machines of several sizes.

    Parameters
    ----------
    spec
        The job.

    Members
    -------
    runs
        `JobRun` by clusters.
    warm
        Cycles of the frustum from `POINT` on one cluster when everything is loaded.
    """

    def __init__(self, spec: JobSpec):
        self.spec, self.runs, self.warm = spec, {}, 0

    def speedup(self, clusters: int) -> float:
        """Over one cluster."""
        return self.runs[1].cycles / self.runs[clusters].cycles

    @property
    def ratio(self) -> float:
        """Mean cycles of the job's frusta on one cluster, divided by `warm`."""
        return self.runs[1].frustum_cycles / self.warm

    def report(self) -> dict:
        """Counts of the largest machine ready for JSON."""
        largest = max(self.runs)
        return self.runs[largest].report() | {
            "speedup": self.speedup(largest), "one_cluster_cycles": self.runs[1].cycles, "point_cycles": self.warm,
            "mean_to_point": self.ratio}


def measure(scenes: list[SceneRuns], config: Config, *, check: bool, **memory) -> None:
    """Run the jobs of all scenes on one machine.

    Parameters
    ----------
    scenes
        The scenes; the runs are added. On one cluster, cells are chosen that the larger machines have too.
    config, memory
        See `job_machine`.
    check
        Compare all results with the golden model's, not those of small jobs alone.
    """
    clusters = config.noc.clusters
    with job_machine(config, **memory) as machine:
        for scene in scenes:
            prepared = prepare_job(replace(scene.spec, group=min(scene.spec.group, clusters)), config)
            scene.spec = replace(scene.spec, cell=prepared.cell)
            small = sum(map(len, prepared.records)) <= CHECKED
            run = scene.runs[clusters] = run_on(machine, prepared, check=check or small)
            if clusters == 1:
                alone = prepare_job(replace(scene.spec, point=POINT, group=1), config)
                scene.warm = round([run_on(machine, alone, check=True) for _ in range(CASTS)][-1].frustum_cycles)
            console().note(f"{scene.spec.scene}, {clusters} clusters: {run.cycles} cycles")


def rows_of(scene: SceneRuns) -> list[list]:
    """A row for each number of clusters."""
    rows = []
    for clusters, run in sorted(scene.runs.items()):
        bounds = run.bounds
        rows.append([scene.spec.scene, clusters, f"{scene.spec.cell:g}", run.cycles,
                     round(run.cycles / len(run.prepared.records)), run.load_cycles, round(run.cast_cycles),
                     *(bounds[name] for name in ("tests", "patches", "memory")),
                     f"{bounds[run.bound] / run.cycles:.2f}", f"{run.efficiency:.3f}",
                     f"{scene.speedup(clusters):.2f}", f"{run.rays / run.cycles:.3f}"])
    return rows


def cycles_rows(scene: SceneRuns) -> list[list]:
    """A row for each number of clusters: where a cluster's cycles go."""
    return [[scene.spec.scene, clusters, run.cycles, *run.cluster_cycles.values()]
            for clusters, run in sorted(scene.runs.items())]


def mean_row(scene: SceneRuns) -> list:
    """The frusta of the job beside the one from `POINT`, on one cluster."""
    run = scene.runs[1]
    return [scene.spec.scene, f"{scene.spec.cell:g}", run.rays, len(run.prepared.request.geometry), scene.warm,
            round(run.frustum_cycles), f"{scene.ratio:.3f}", f"{run.tests / run.rays:.2f}"]


def write_roofline(path: Path, scene: SceneRuns) -> None:
    """Rays per cycle against clusters: what was measured, below what tests, patches and the memory port allow."""
    largest = max(scene.runs)
    one, run, end = scene.runs[1], scene.runs[largest], 2 * largest
    x = np.array([0, end])
    limits = [Line(name="tests", x=x, y=x * one.rays / one.bounds["tests"]),
              Line(name="patches", x=x, y=x * one.rays / max(1, one.bounds["patches"])),
              Line(name="memory port", x=x, y=np.full(2, run.rays / run.bounds["memory"]))]
    clusters = np.array([0, *sorted(scene.runs)])
    measured = np.array([0, *(scene.runs[count].rays / scene.runs[count].cycles for count in clusters[1:])])
    write_figure(path, line_figure(
        [*limits, Line(name="measured", x=clusters, y=measured)], title=_title(scene),
        x_name="clusters", y_name="rays per cycle", y_top=1.1 * float(limits[0].y[-1])))


def activity_figure(run: JobRun, *, title: str) -> "Figure":
    """A chart with a lane for loads, and one for each cluster: its casts, above the writing of their results."""
    sections = run.sections[np.lexsort((run.since_begin(run.sections["begin"]), run.sections["cluster"]))]
    lane, begins, ends = 1 + sections["cluster"], run.since_begin(sections["begin"]), run.since_begin(sections["end"])
    cast = begins + sections["cycles"]
    # A cluster's casts alternate between two shades, so that their borders are seen.
    is_odd = (np.arange(len(lane)) - np.searchsorted(lane, lane)) % 2 == 1
    loads = [run.since_begin(run.loads[name]) for name in ("begin", "end")]
    bars = [Bars(lane=np.zeros(len(run.loads)), begin=loads[0], end=loads[1], colour=COLOURS[4], name="load"),
            *(Bars(lane=lane[shade], begin=begins[shade], end=cast[shade], colour=colour, bottom=0.65, name=name)
              for shade, colour, name in ((~is_odd, COLOURS[0], "cast"), (is_odd, COLOURS[5], "next cast"))),
            Bars(lane=lane, begin=cast, end=ends, colour=COLOURS[2], top=0.65, name="results")]
    return lane_figure(["loads", *(f"cluster {number}" for number in range(run.clusters))], bars, title=title,
                       x_name="cycle")


def _title(scene):
    spec = scene.spec
    return f"{spec.scene}: {spec.frusta} hemispheres of {spec.rays[0]} x {spec.rays[1]} rays, cell {spec.cell:g}"


@benchmark("jobs")
@click.option("--scene", help="Measure one scene, and report it as one object.  [default: tables of cornell, lobby, "
              "room1627, tetra and man]")
@click.option("--clusters", type=click.Choice(["1", "2", "4", "8", "16", "32", "64"]), default="16",
              help="Simulate this many clusters beside one; without --scene half as many too.")
@click.option("--frusta", type=click.IntRange(1, 1 << 14), default=247, help="Cast this many hemispheres.")
@METHOD_CELL
@RAYS
@click.option("--hits", type=click.Choice(list(FORMATS)), default="none", help="Have hits of this format written.")
@click.option("--sums/--no-sums", default=True, help="Have the sparse sums written.")
@click.option("--group", type=click.Choice(["1", "2", "4", "8", "16"]), default="1",
              help="Cut each frustum into sections for so many clusters.")
@click.option("--check", is_flag=True, help="Compare the results of large jobs too with the golden model's: minutes.")
@click.option("--latency", type=click.IntRange(1), default=10, help="Set the latency of main memory in cycles.")
@click.option("--spread", type=click.IntRange(0), default=0, help="Add a random delay of at most so many cycles to "
              "each read of main memory, and return replies in any order.")
@click.option("--memory-seed", type=click.IntRange(0, (1 << 32) - 1), default=1, help="Set the seed of --spread.")
@PRESET
@ASSIGNMENTS
def main(scene, clusters, frusta, cell, rays, hits, sums, group, check, latency, spread, memory_seed, preset,
         assignments) -> None:
    """Count the cycles of jobs of many hemispheres, loads and results with them."""
    most = int(clusters)
    counts = sorted({1, most} if scene else {1, max(1, most // 2), most})
    found = [SceneRuns(JobSpec(scene=name, rays=rays, frusta=frusta, cell=cell, hit_format=FORMATS[hits], sums=sums,
                               group=int(group))) for name in ([scene] if scene else SCENES)]
    for count in counts:
        config = machine_config(preset, assignments, rays, clusters=count,
                                topology=None if preset in WHOLE else "mesh")
        measure(found, config, check=check, latency=latency, spread=spread, shuffles=spread > 0, seed=memory_seed,
                progress=console().progress)
    for one in found:
        write_roofline(page_path().parent / f"jobs-{one.spec.scene}-roofline.svg", one)
        write_figure(page_path().parent / f"jobs-{one.spec.scene}-activity.svg",
                     activity_figure(one.runs[max(one.runs)], title=_title(one)))
    given = {"preset": preset, "changes": list(assignments), "hits": hits, "sums": sums, "group": int(group),
             "latency": latency, "spread": spread, "seed": memory_seed, "rays_per_frustum": list(rays)}
    write_report(
        "Jobs",
        f"{provenance('amaranth')}; preset {' '.join((preset, *assignments))}, {frusta} hemispheres of {rays[0]} x "
        f"{rays[1]} rays from points of the ceiling, {cell_text(cell)}, hits: {hits}, sums: "
        f"{'yes' if sums else 'no'}, clusters for a frustum: {group}, main memory {latency} to {latency + spread} "
        f"cycles away (seed {memory_seed}).",
        "Cycles: from the beginning of the first load to the last result. Cast: mean cycles that a cluster casts. "
        "Lower bounds in cycles: tests, four cycles for a patch, beats over the memory port. Efficiency: tests for "
        "each cluster and cycle.",
        table(HEAD, [row for one in found for row in rows_of(one)]),
        "Where the cycles of a cluster go, on average. Waits: between its casts, for the next section, for the results "
        "of the one before or for the rays. Last results: from its last cast's end on. Idle: until the job ends.",
        table(CYCLES_HEAD, [row for one in found for row in cycles_rows(one)]),
        f"Frusta on one cluster, beside the one from point {POINT} of 16 with the same cells:",
        table(MEAN_HEAD, [mean_row(one) for one in found]),
        report=found[0].report() | {"file": str(page_path()), "configuration": given | {
            "parameters": config.parameters()}, "versions": versions("amaranth", "numpy") | {
            "Verilator": verilator_version()}} if scene else None)
