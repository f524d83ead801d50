"""Cycles of frusta on the machine, beside lower bounds.

``radiosity bench engine`` casts hemispheres from each scene's ceiling on the RTL, cold and warm, and writes
out/bench/engine.md: cycles beside lower bounds, and the reasons of stalls. Hits and sums must be golden's.
"""

from dataclasses import dataclass

import click
import numpy as np

from golden.cast.rays import Rays
from golden.cast.shelling import Shelling
from golden.commands.console import console
from golden.commands.parameters import ASSIGNMENTS, METHOD_CELL, PRESET, WholePair
from golden.config import PRESETS, Config
from golden.frustum import FrustumRecord, Hemisphere, hemisphere_record
from golden.memory_map import MemoryImage, machine_image
from golden.scene.open import open_scene
from golden.scene.patch_geometry import PatchGeometry
from golden.scene.scene import Scene
from golden.schedule.ceiling_points import ceiling_points
from golden.schedule.cell_choice import choose_cell
from golden.schedule.phase import machine_schedule
from hw.simulator.cast_report import cast_report
from hw.simulator.simulated_machine import SimulatedMachine
from hw.simulator.simulation_config import simulation_config
from radiosity.benchmarks.report import cell_text, output_option, provenance, write_report

__all__ = ["SCENES", "PreparedCast", "measure", "prepare_cast", "rows_of"]

SCENES, CLUSTERS = ("cornell", "lobby", "room1627", "tetra", "man"), (1, 2, 4, 8, 16)
# Points of the ceiling that the phase is scheduled from, and that is cast from; rays for each one that schedules.
REFERENCE, POINT, RATIO = 0, 5, 64
# Casts until caches and cleared memories are the same each time.
CASTS = 3
STALLS = ("traversal_waits_for_survival", "traversal_waits_for_rays", "traversal_waits_for_traversal",
          "traversal_waits_for_cells", "intersection_waits_for_slot", "intersection_waits_for_rays", "memory_stalls")


@dataclass(frozen=True, kw_only=True, eq=False)
class PreparedCast:
    """A hemisphere from a scene's ceiling, and golden's answer.

    Parameters
    ----------
    scene, patches, record, cell
        What is cast into what, how many patches it has for the machine, and the size of its cells.
    rays
        The machine's, in the scene.
    image, expected
        What the machine is given, and what it must write.
    total
        What the weights of the rays add up to.
    """

    scene: Scene
    patches: int
    record: FrustumRecord
    cell: float
    rays: Rays
    image: MemoryImage
    expected: MemoryImage
    total: int


def prepare_cast(config: Config, scene: str, *, cell: float | None, rays: tuple[int, int]) -> PreparedCast:
    """A hemisphere at a point that the phase was not scheduled from; without a cell size, in cells chosen for it."""
    opened, hemisphere = open_scene(scene), Hemisphere(*rays)
    points, down = ceiling_points(opened)
    geometry = PatchGeometry.of(opened, config.numbers, points)
    reference, record = (hemisphere_record(hemisphere, geometry.coordinates, points[point], down)
                         for point in (REFERENCE, POINT))
    cell = choose_cell([record], geometry, config).cell if cell is None else cell
    shelling = Shelling(geometry, config, cell=cell)
    plan = machine_schedule(reference, geometry, shelling.table, config, ratio=RATIO)
    image = machine_image(record, geometry, shelling.table, config, plan, weights=hemisphere.polar_weights)
    directions = record.all_directions() @ record.to_global.T
    origin = geometry.coordinates.points(record.origin)
    return PreparedCast(scene=opened, patches=len(geometry), record=record, cell=cell,
                 rays=Rays(np.broadcast_to(origin, directions.shape), directions), image=image,
                 expected=image.with_results(shelling.cast(record)[0]),
                 total=int(hemisphere.polar_weights.sum()) * record.columns)


def measure(machine: SimulatedMachine, prepared: PreparedCast) -> dict:
    """What `hw.simulator.cast_report.cast_report` says of it.

    Raises
    ------
    SystemExit
        Hits or sums are not golden's.
    """
    done = [machine.cast(prepared.image, total=prepared.total, sums=True, again=number > 0) for number in range(CASTS)]
    for one in done:
        for name in "hits", "sums":
            if one.image[name].tobytes() != prepared.expected[name].tobytes():
                raise SystemExit(f"error: {prepared.scene.name}, {machine.config.noc.nodes} clusters: {name} are not "
                                 "golden's")
    return {"patches": prepared.patches, "cell": prepared.cell, **cast_report(prepared.record, done, machine.config)}


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
            f"| {scene} | {clusters} | {one['cell']:g} | {one['first_cycles']} | {one['cycles']} "
            f"| {bound['traversal']} | {bound['intersection']} "
            f"| {bound['patches']} | {one['of_bound']:.2f} | {one['efficiency']:.3f} "
            f"| {lowest:.3f} | {speedup:.2f} | {most:.2f} | {one['tests_per_ray']:.2f} | {one['edrc']:.1f} "
            f"| {sources['own']} | {sources['remote']} | {sources['hits']} | {sources['misses']} "
            f"| {one['links']:.2f} |")
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
    """Count the machine's cycles for a hemisphere; SCENES default to cornell, lobby, room1627, tetra and man."""
    found = {scene: {} for scene in scenes or SCENES}
    for count in clusters:
        config = simulation_config(PRESETS[preset].with_parameters(assignments), clusters=count, topology="mesh",
                               given=tuple(one.partition("=")[0] for one in assignments), rays=rays[0] * rays[1])
        with SimulatedMachine(config, latency=latency) as machine:
            for scene, by_clusters in found.items():
                by_clusters[count] = measure(machine, prepare_cast(config, scene, cell=cell, rays=rays))
                console().note(f"{scene}, {count} clusters: {by_clusters[count]['cycles']} cycles")
    rows = [rows_of(scene, by_clusters) for scene, by_clusters in found.items()]
    write_report(output, [
        "# Frusta on the machine", "",
        f"{provenance('amaranth')}; preset {' '.join((preset, *assignments))}, {rays[0]} x {rays[1]} rays, "
        f"{cell_text(cell)}, main memory {latency} cycles away, a hemisphere at a point of the ceiling that the "
        "phase was not scheduled from, no subshells. Hits and sums are golden's.", "",
        "Cold: the first frusta of a phase. Bound: traversal (steps per pipeline, cells met, grid rays sent, or "
        "eighths of those looked at), intersection (tests), four cycles per patch, each of the busiest cluster. "
        "Patches: in the resident set, of another cluster, in the cache, in main memory.", "",
        "| scene | clusters | cell | cold | warm | traversal | intersection | patches | bound : warm | efficiency "
        "| lowest | speedup | by the bound | tests per ray | tests per patch | own | remote | cache | main | links |",
        "|---" * 20 + "|", *(line for cycles, _ in rows for line in cycles), "",
        "Cycles in which something waited, of the cluster with most of them:", "",
        f"| scene | clusters | warm | {' | '.join(name.replace('_', ' ') for name in STALLS)} |",
        "|---" * (3 + len(STALLS)) + "|", *(line for _, stalls in rows for line in stalls)])
