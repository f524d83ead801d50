"""Cycles of one frustum on the machine, beside lower bounds.

``radiosity bench engine`` has a hemisphere from each scene's ceiling cast in jobs of one frustum, cold and warm, cut
into sections for several clusters. It writes out/bench/engine.md: cycles beside lower bounds, and the reasons of
stalls. Hits and sums must be golden's. Jobs of many frusta: `radiosity.benchmarks.jobs`.
"""

import click

from golden.commands.console import console
from golden.commands.parameters import ASSIGNMENTS, METHOD_CELL, PRESET, WholePair
from golden.config import PRESETS, Config
from golden.jobs.result_formats import HitFormat
from hw.ctu.ctu_formats import GRID_GROUP
from hw.simulator.simulated_port import complete
from hw.simulator.simulation_config import simulation_config
from radiosity.benchmarks.job_runs import JobMachine, JobRun, JobSpec, PreparedJob, prepare_job
from radiosity.benchmarks.report import cell_text, output_option, provenance, write_report

__all__ = ["CLUSTERS", "SCENES", "STALLS", "cast_cycles", "measure", "prepare_cast", "rows_of"]

SCENES, CLUSTERS = ("cornell", "lobby", "room1627", "tetra", "man"), (1, 2, 4, 8, 16)
# The point of the ceiling's 16 that is cast from.
POINT = 5
STALLS = ("traversal_waits_for_survival", "traversal_waits_for_rays", "traversal_waits_for_traversal",
          "traversal_waits_for_cells", "intersection_waits_for_slot", "intersection_waits_for_rays", "memory_stalls")
# Counters that a section does not clear.
_SINCE_RESET = ("memory_stalls",)


def prepare_cast(config: Config, scene: str, *, cell: float | None, rays: tuple[int, int]) -> PreparedJob:
    """The job of one hemisphere, a section for each cluster; without a cell size, in cells chosen for it."""
    return prepare_job(JobSpec(scene=scene, rays=rays, point=POINT, cell=cell, hit_format=HitFormat.FULL,
                               group=config.noc.nodes), config)


def cast_cycles(run: JobRun) -> int:
    """From the begin of the first section to the end of the last cast."""
    begins = run.since_begin(run.sections["begin"])
    return int((begins + run.sections["cycles"]).max() - begins.min())


def measure(machine: JobMachine, prepared: PreparedJob) -> dict:
    """Cycles of the first and of the third cast, bounds, rates, and the counters of each cluster.

    Raises
    ------
    SystemExit
        Hits or sums are not golden's.
    """
    first = machine.run(prepared, check=True)
    machine.again(prepared)
    before = complete(machine.host.counters())
    last = machine.again(prepared, check=True)
    each = [one | {name: one[name] - earlier[name] for name in _SINCE_RESET}
            for one, earlier in zip(complete(machine.host.counters()), before, strict=True)]
    cycles, bound = cast_cycles(last), _bound(each, machine.config)
    return {"patches": prepared.patches, "cell": prepared.cell, "rays": last.rays, "cycles": cycles,
            "first_cycles": cast_cycles(first), "load_cycles": first.load_cycles, "job_cycles": first.cycles,
            "bound": bound, "of_bound": max(bound.values()) / cycles,
            "efficiency": last.tests / cycles / machine.config.noc.nodes, "tests_per_ray": last.tests / last.rays,
            "edrc": last.tests / max(1, sum(last.patches.values())), "sources": last.patches,
            "each": [{"efficiency": one["intersection_tested"] / cycles, **one} for one in each]}


def _bound(each, config):
    """What the unit of the busiest cluster needs at its full rate, see `rows_of`."""
    pipelines = config.ctu.traversal_pipelines(config.noc.nodes)
    return {"traversal": max(max(-(-one["traversal_steps"] // pipelines), one["traversal_cells"],
                                 one["traversal_rays"], -(-one["traversal_requests"] // GRID_GROUP)) for one in each),
            "intersection": max(one["intersection_tested"] for one in each),
            "patches": max(4 * one["intersection_patches"] for one in each)}


def rows_of(scene: str, found: dict[int, dict]) -> tuple[list[str], list[str]]:
    """A row for each number of clusters: cycles and rates, and where cycles went, of the cluster with most of each."""
    cycles, stalls = [], []
    first = found[min(found)]
    for clusters, one in found.items():
        bound, sources = one["bound"], one["sources"]
        speedup = first["cycles"] / one["cycles"]
        most = max(first["bound"].values()) / max(bound.values())
        lowest = min(each["efficiency"] for each in one["each"])
        cycles.append(
            f"| {scene} | {clusters} | {one['cell']:g} | {one['job_cycles']} | {one['load_cycles']} "
            f"| {one['first_cycles']} | {one['cycles']} | {bound['traversal']} | {bound['intersection']} "
            f"| {bound['patches']} | {one['of_bound']:.2f} | {one['efficiency']:.3f} "
            f"| {lowest:.3f} | {speedup:.2f} | {most:.2f} | {one['tests_per_ray']:.2f} | {one['edrc']:.1f} "
            f"| {sources['own']} | {sources['remote']} | {sources['hits']} | {sources['misses']} |")
        stalls.append(f"| {scene} | {clusters} | {one['cycles']} | " + " | ".join(
            str(max(each[name] for each in one["each"])) for name in STALLS) + " |")
    return cycles, stalls


@click.command()
@click.argument("scenes", nargs=-1)
@output_option("engine")
@click.option("--clusters", type=click.IntRange(1), multiple=True, default=CLUSTERS,
              help="Simulate this many clusters; may be repeated.")
@METHOD_CELL
@click.option("--rays", type=WholePair("AZIMUTHSxPOLARS"), default="256x64", help="Set the number of rays of the "
              "hemisphere.")
@click.option("--latency", type=click.IntRange(1), default=10, help="Set the latency of main memory in cycles.")
@PRESET
@ASSIGNMENTS
def main(scenes, output, clusters, cell, rays, latency, preset, assignments) -> None:
    """Count the cycles of one hemisphere; SCENES default to cornell, lobby, room1627, tetra and man."""
    found = {scene: {} for scene in scenes or SCENES}
    for count in clusters:
        config = simulation_config(PRESETS[preset].with_parameters(assignments), clusters=count, topology="mesh",
                               given=tuple(one.partition("=")[0] for one in assignments), rays=rays[0] * rays[1])
        with JobMachine(config, latency=latency) as machine:
            for scene, by_clusters in found.items():
                by_clusters[count] = measure(machine, prepare_cast(config, scene, cell=cell, rays=rays))
                console().note(f"{scene}, {count} clusters: {by_clusters[count]['cycles']} cycles")
    rows = [rows_of(scene, by_clusters) for scene, by_clusters in found.items()]
    write_report(output, [
        "# A frustum on the machine", "",
        f"{provenance('amaranth')}; preset {' '.join((preset, *assignments))}, {rays[0]} x {rays[1]} rays from "
        f"point {POINT} of the ceiling, {cell_text(cell)}, main memory {latency} cycles away, a section for each "
        "cluster. Hits and sums are golden's.", "",
        "Job: from the begin of the load to the last result, of the first frustum. Cold: its cast. Warm: the third "
        "cast of the same frustum. Bound: traversal (steps per pipeline, cells met, grid rays sent, or eighths of "
        "those looked at), intersection (tests), four cycles per patch, each of the busiest cluster. Patches: in the "
        "cluster's own memory, of another cluster, in the cache, in main memory.", "",
        "| scene | clusters | cell | job | load | cold | warm | traversal | intersection | patches | bound : warm "
        "| efficiency | lowest | speedup | by the bound | tests per ray | tests per patch | own | remote | cache "
        "| main |",
        "|---" * 21 + "|", *(line for cycles, _ in rows for line in cycles), "",
        "Cycles in which something waited, of the cluster with most of them:", "",
        f"| scene | clusters | warm | {' | '.join(name.replace('_', ' ') for name in STALLS)} |",
        "|---" * (3 + len(STALLS)) + "|", *(line for _, stalls in rows for line in stalls)])
