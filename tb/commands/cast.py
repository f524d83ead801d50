"""``cast``: one frustum on the machine, its hits beside golden's, and where its cycles went."""

import csv
import json
import sys
from pathlib import Path

import click

from golden.cast.shelling import Shelling
from golden.commands.cast import asked_frustum
from golden.commands.parameters import FILE, SCENE_HELP, Triple, WholePair
from golden.frustum import Hemisphere
from golden.memory_map import machine_image
from golden.output import check_outputs, whole_file
from golden.scene.open import open_scene
from golden.schedule.phase import machine_schedule
from hw.simulator.cast_report import cast_report
from hw.simulator.cast_result import CastResult
from hw.simulator.simulated_machine import WaveformWindow
from radiosity.timeline import write_timeline
from tb.commands.machine_options import cell_option, machine_config, machine_options, open_rig

__all__ = ["cast", "write_counters"]


@click.command(epilog=SCENE_HELP)
@click.argument("scene")
@click.option("--origin", type=Triple(), help="Where the rays of a hemisphere start.")
@click.option("--normal", type=Triple(), help="The middle of the hemisphere.")
@click.option("--patch", type=int, metavar="NUMBER", help="Origin and normal: the middle of this patch's front.")
@click.option("--rays", type=WholePair("AZIMUTHSxPOLARS"), default="256x64", help="Of a hemisphere, powers of two.")
@click.option("--screen", type=WholePair("WIDTHxHEIGHT"), help="Cast a screen through the scene's view instead.")
@cell_option
@click.option("--ratio", type=int, default=64, help="Rays of the frustum for each ray cast to schedule it.")
@click.option("--casts", type=click.IntRange(1, 1000), default=3, help="Casts one after the other: the caches, and "
              "memories that have been cleared, are the same from the third one on.")
@machine_options
@click.option("--timeline", type=FILE, help="Chart of what is busy when, of the last cast. (.svg)")
@click.option("--waves", type=FILE, help="Signals of the last cast. (.vcd)")
@click.option("--waves-begin", type=click.IntRange(0), default=0, help="From this cycle of the cast on.")
@click.option("--waves-cycles", type=click.IntRange(1, 1_000_000), default=2000, help="So many cycles.")
@click.option("--csv", "table", type=FILE, help="Counters, a row for each cluster of each cast. (.csv)")
@click.option("--json", "as_json", is_flag=True, help="Print one JSON object.")
def cast(scene, origin, normal, patch, rays, screen, cell, ratio, casts, timeline, waves, waves_begin,
         waves_cycles, table, as_json, **machine):
    """Cast one hemisphere or screen into SCENE on the machine.

    Exits with code 1 if its hits or sums are not golden's.
    """
    check_outputs(timeline, suffixes=(".svg",))
    check_outputs(waves, suffixes=(".vcd",))
    check_outputs(table, suffixes=(".csv",))
    config = machine_config(**machine)
    record, geometry = asked_frustum(open_scene(scene), config, origin, normal, patch, rays, screen)
    shelling = Shelling(geometry, config, cell=cell)
    plan = machine_schedule(record, geometry, shelling.table, config, ratio=ratio)
    weights = None if screen else Hemisphere(*rays).polar_weights
    image = machine_image(record, geometry, shelling.table, config, plan, weights=weights)
    expected = image.with_results(shelling.cast(record)[0])
    traces = WaveformWindow(path=waves, begin=waves_begin, cycles=waves_cycles) if waves else None
    with open_rig(config, traced=waves is not None, **machine) as simulated:
        samples, done = [], []
        for number in range(casts):
            is_last = number == casts - 1
            done.append(simulated.cast(
                image, total=0 if weights is None else int(weights.sum()) * record.columns, sums=True, again=number > 0,
                timeline=samples if timeline and is_last else None, waves=traces if is_last else None))
    if table:
        write_counters(table, done)
    if timeline:
        write_timeline(timeline, samples, config, title=f"{scene}, {config.noc.nodes} clusters")
    report = {"scene": scene, "patches": len(geometry), "clusters": config.noc.nodes,
              "topology": config.noc.topology, **cast_report(record, done, config)}
    report["differences"] = len(done[-1].image.hits().differences(expected.hits()))
    report["sums"] = int((done[-1].image["sums"] != expected["sums"]).sum())
    click.echo(json.dumps(report, indent=1) if as_json else _text(report))
    if report["differences"] or report["sums"]:
        sys.exit(1)


def write_counters(path: Path, done: list[CastResult]) -> None:
    """Counters as a table: cast, cluster, cycles, and the counters' names; a row for each cluster of each cast."""
    with whole_file(path) as part, part.open("w", newline="") as file:
        rows = csv.writer(file)
        rows.writerow(["cast", "cluster", "cycles", *done[0].counters[0]])
        for number, one in enumerate(done):
            for cluster, counters in enumerate(one.counters):
                rows.writerow([number, cluster, one.cycles, *counters.values()])


def _text(report: dict) -> str:
    bound, sources = report["bound"], report["sources"]
    lines = [
        f"{report['scene']}: {report['patches']} patches, {report['rays']} rays, {report['hits']} hits, "
        f"{report['clusters']} clusters, {report['topology']}",
        f"differences from golden: {report['differences']} hits, {report['sums']} sums",
        f"cycles {report['cycles']} (the first time {report['first_cycles']}), tables {report['load_cycles']}, "
        f"results {report['result_cycles']}",
        "bound  " + ", ".join(f"{name} {cycles}" for name, cycles in bound.items())
        + f": {report['of_bound']:.2f} of the cycles",
        f"pipeline efficiency {report['efficiency']:.3f}, tests per ray {report['tests_per_ray']:.2f}, "
        f"tests per patch {report['edrc']:.1f}",
        f"patches: own {sources['own']}, remote {sources['remote']}, cache {sources['hits']}, main memory "
        f"{sources['misses']}; {report['links']:.2f} links on the way",
        "", f"{'cluster':28} " + " ".join(f"{number:>9}" for number in range(report["clusters"]))]
    for name in report["each"][0]:
        values = [one[name] for one in report["each"]]
        lines.append(f"{name.replace('_', ' '):28} " + " ".join(
            f"{value:9.3f}" if isinstance(value, float) else f"{value:9}" for value in values))
    return "\n".join(lines)
