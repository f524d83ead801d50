"""Cycles of one frustum on the machine, beside lower bounds.

``radiosity bench engine`` has a hemisphere from each scene's ceiling cast in jobs of one frustum, cold and warm, cut
into sections for several clusters. It writes out/bench/engine.md: cycles beside lower bounds, and the reasons of
stalls. Hits and sums must be golden's. Jobs of many frusta: `benchmarks.jobs`.
"""

import click

from benchmarks.report import benchmark, cell_text, provenance, table, write_report
from golden.engine.config import PRESETS, Config
from golden.engine.jobs.result_formats import HitFormat
from radiosity.cli.console import console
from radiosity.cli.parameters import ASSIGNMENTS, PRESET, rays_option
from radiosity.flow.simulator.cast_report import cast_report
from radiosity.flow.simulator.simulated_machine import SimulatedMachine
from radiosity.flow.simulator.simulation_config import simulation_config
from radiosity.machines.engine.job_runs import JobSpec, PreparedJob, check_results, job_machine, prepare_job

__all__ = ["CLUSTERS", "LATENCY", "POINT", "RAYS", "SCENES", "STALLS", "machine_config", "measure", "prepare_cast",
           "rows_of"]

SCENES, CLUSTERS = ("cornell", "lobby", "room1627", "tetra", "man"), (1, 2, 4, 8, 16)
# The point of the ceiling's 16 that is cast from.
POINT = 5
STALLS = ("traversal_waits_for_survival", "traversal_waits_for_rays", "traversal_waits_for_traversal",
          "traversal_waits_for_cells", "intersection_waits_for_slot", "intersection_waits_for_rays", "memory_stalls")
# Casts of the frustum: from the third one on it is warm.
CASTS = 3
# Cycles of main memory.
LATENCY = 10
RAYS = rays_option()


def machine_config(preset: str, assignments: tuple[str, ...], rays: tuple[int, int], *, clusters: int = 1,
                   topology: str | None = "mesh") -> Config:
    """The configuration of a machine; a topology of None is the preset's."""
    return simulation_config(PRESETS[preset].with_parameters(assignments), clusters=clusters, topology=topology,
                             given=tuple(one.partition("=")[0] for one in assignments), rays=rays[0] * rays[1])


def prepare_cast(config: Config, scene: str, *, cell: float | None, rays: tuple[int, int]) -> PreparedJob:
    """The job of one hemisphere, a section for each cluster; without a cell size, in cells chosen for it."""
    return prepare_job(JobSpec(scene=scene, rays=rays, point=POINT, cell=cell, hit_format=HitFormat.FULL,
                               group=config.noc.clusters), config)


def measure(machine: SimulatedMachine, prepared: PreparedJob) -> dict:
    """What `radiosity.flow.simulator.cast_report.cast_report` says of it, and the cycles of the first cast as ``cold``.

    Raises
    ------
    SystemExit
        Hits or sums differ from the golden model's.
    """
    done = [machine.run([prepared.request]) for _ in range(CASTS)]
    for one in done:
        check_results(prepared, one, machine.config)
    return {"patches": len(prepared.request.geometry), "cell": prepared.cell, "cold": done[0].cycles.cast,
            **cast_report(prepared.records[0], done, machine.config)}


def rows_of(scene: str, found: dict[int, dict]) -> tuple[list[list], list[list]]:
    """A row for each number of clusters: cycles and rates, and where cycles went, of the cluster with most of each."""
    cycles, stalls = [], []
    first = found[min(found)]
    for clusters, one in found.items():
        bound, sources = one["bound"], one["sources"]
        speedup = first["cast_cycles"] / one["cast_cycles"]
        most = max(first["bound"].values()) / max(bound.values())
        lowest = min(each["efficiency"] for each in one["each"])
        cycles.append([
            scene, clusters, f"{one['cell']:g}", one["first_cycles"], one["load_cycles"], one["cold"],
            one["cast_cycles"], bound["traversal"], bound["intersection"], bound["patches"], f"{one['of_bound']:.2f}",
            f"{one['efficiency']:.3f}", f"{lowest:.3f}", f"{speedup:.2f}", f"{most:.2f}", f"{one['tests_per_ray']:.2f}",
            f"{one['edrc']:.1f}", *(sources[name] for name in ("own", "kept", "remote", "hits", "misses"))])
        stalls.append([scene, clusters, one["cast_cycles"], *(
            max(each[name] for each in one["each"]) for name in STALLS)])
    return cycles, stalls


@benchmark("engine", SCENES)
@click.option("--clusters", type=click.IntRange(1), multiple=True, default=CLUSTERS,
              help="Simulate this many clusters; may be repeated.")
@RAYS
@PRESET
@ASSIGNMENTS
def main(scenes, clusters, rays, preset, assignments) -> None:
    """Count the cycles of one hemisphere; SCENES default to cornell, lobby, room1627, tetra and man."""
    found = {scene: {} for scene in scenes}
    for count in clusters:
        config = machine_config(preset, assignments, rays, clusters=count)
        with job_machine(config, latency=LATENCY) as machine:
            for scene, by_clusters in found.items():
                by_clusters[count] = measure(machine, prepare_cast(config, scene, cell=None, rays=rays))
                console().note(f"{scene}, {count} clusters: {by_clusters[count]['cast_cycles']} cycles")
    rows = [rows_of(scene, by_clusters) for scene, by_clusters in found.items()]
    write_report(
        "A frustum on the machine",
        f"{provenance('amaranth')}; preset {' '.join((preset, *assignments))}, {rays[0]} x {rays[1]} rays from "
        f"point {POINT} of the ceiling, {cell_text(None)}, main memory {LATENCY} cycles away, a section for each "
        "cluster. Hits and sums are golden's.",
        "Job: from the doorbell to the last result, of the first frustum. Cold: its cast. Warm: the third "
        "cast of the same frustum. Bound: traversal (steps per pipeline, cells met, grid rays sent, or eighths of "
        "those looked at), intersection (tests), four cycles per patch, each of the busiest cluster. Patches: in the "
        "cluster's own memory, in its patch store, of another cluster, in the cache, in main memory.",
        table(["scene", "clusters", "cell", "job", "load", "cold", "warm", "traversal", "intersection", "patches",
               "bound : warm", "efficiency", "lowest", "speedup", "by the bound", "tests per ray", "tests per patch",
               "own", "store", "remote", "cache", "main"], [row for cycles, _ in rows for row in cycles]),
        "Cycles in which something waited, of the cluster with most of them:",
        table(["scene", "clusters", "warm", *(name.replace("_", " ") for name in STALLS)],
              [row for _, stalls in rows for row in stalls]))
