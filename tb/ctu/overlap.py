"""Subshells that overlap in time, in the RTL of the back end of cell traversal.

``python -m tb.ctu.overlap`` casts a hemisphere of five scenes with a barrier after each shell and with as many
stages ahead as the configuration says, in Verilator, and writes out/bench/overlap.md: the cycles of both, how many of
them had grid rays of several subshells in flight, and when each stage of a part of a frustum was.
"""

import json
from itertools import pairwise
from pathlib import Path

import click
import cocotb
from cocotb.triggers import ClockCycles
from cocotb.utils import get_sim_time

from benchmarks.report import provenance
from benchmarks.traversal import INTERSECTION, MEMORY, SCENES
from golden.engine.stimulus.ctu.records import traversal_record
from hw.ctu.ray_traversal import RayTraversal
from tb.ctu.traversal_bench import FINAL, ClusterPart, Intersection, Surroundings
from tb.lib.clocking import PERIOD, start
from tb.lib.configurations import config_of
from tb.lib.runner import BUILD, options, simulate

CELL, RUN_AHEADS = 0.125, (0, 2)
CHANGES = {"ctu.shell_bits": 6, "ctu.subshell_bits": 10, "icu.rays": 4096, "icu.side_bits": 6, "icu.generation_bits": 2}
# Of the timing diagram: characters across, and stages of the scene that is shown.
ACROSS, SHOWN, SCENE = 72, 24, "room1627"


@cocotb.test()
async def cast(dut):
    """One cluster's frustum; counters, and from when to when each stage was in flight."""
    given = options()
    await start(dut, cycles=2_000_000)
    config = config_of(given["changes"])
    record = traversal_record(given["scene"], cell=CELL, config=config)
    one = record.sectors[0]
    part = ClusterPart(record.shelling, record.record, one.sector, config)
    around = Surroundings(dut, RayTraversal(config=config), part)
    tests = Intersection(around, delay=lambda random: MEMORY + INTERSECTION, seed=1)
    depth = config.ctu.run_ahead
    stages = [stage for stage in part.cluster.schedule(one.subshells, tests.tests.window) if stage[1] > 1]
    await around.begin()
    first = round(get_sim_time("ns") / PERIOD)
    begins = []
    for number, (_, shell, window) in enumerate(stages):
        await around.ports.until(lambda number=number: around.over + depth >= number)
        begins.append(round(get_sim_time("ns") / PERIOD))
        await around.ports.send("i", part.requests(number, shell, window))
    await around.ports.send("i", [FINAL])
    await around.ports.until(lambda: around.final)
    await ClockCycles(dut.clk, 3)
    assert tests.idle, "the frustum is over while patches are tested"
    assert not len(tests.hits().differences(record.hits)), "rays hit something else"
    over = around.ports.sinks["o_over"].cycles
    Path("counts.json").write_text(json.dumps({"counters": around.ports["counters"], "stages": [
        {"subshell": int(subshell), "shell": int(shell), "begins": begin - first, "ends": end - first}
        for (subshell, shell, _), begin, end in zip(stages, begins, over, strict=True)]}))


def measure(scene: str, depth: int) -> dict:
    """What `cast` counted."""
    changes = {**CHANGES, "ctu.run_ahead": depth}
    name = f"overlap-{scene}-{depth}"
    component = RayTraversal(config=config_of(changes))
    simulate(component, "tb.ctu.overlap", ("cast",), name=name, changes=changes, scene=scene)
    return json.loads((BUILD / "results" / name / "counts.json").read_text())


def diagram(stages: list[dict]) -> list[str]:
    """Stages in flight, from above in their order, time from left to right."""
    # Where the subshells change most.
    changes = [a["subshell"] != b["subshell"] for a, b in pairwise(stages)]
    begin = max(range(max(1, len(stages) - SHOWN + 1)), key=lambda k: sum(changes[k:k + SHOWN - 1]))
    shown = stages[begin:begin + SHOWN]
    first, last = shown[0]["begins"], max(stage["ends"] for stage in shown)
    scale = ACROSS / (last - first)
    lines = [f"{'subshell':>8} {'shell':>5}  cycles {first} to {last}"]
    for stage in shown:
        left, right = (int((stage[name] - first) * scale) for name in ("begins", "ends"))
        lines.append(f"{stage['subshell']:>8} {stage['shell']:>5}  {' ' * left}{'#' * max(1, right - left)}")
    return lines


@click.command()
@click.option("-o", "--output", type=click.Path(dir_okay=False, path_type=Path), default="out/bench/overlap.md")
def main(output: Path) -> None:
    """Write the table."""
    rows, picture = [], []
    for scene in SCENES:
        barrier, ahead = (measure(scene, depth) for depth in RUN_AHEADS)
        counts, before = ahead["counters"], barrier["counters"]
        rows.append(f"| `{scene}` | {len({stage['subshell'] for stage in ahead['stages']})} | {len(ahead['stages'])} "
                    f"| {before['cycles']} | {counts['cycles']} | {before['cycles'] / counts['cycles']:.2f} "
                    f"| {before['overlaps']} | {counts['overlaps']} |")
        click.echo(rows[-1])
        if scene == SCENE:
            picture = diagram(ahead["stages"])
    lines = [
        "# Subshells that overlap", "",
        f"{provenance('amaranth', 'cocotb')}; RTL of `RayTraversal`, one pipeline, hemispheres of 64 x 16 rays, cell "
        f"{CELL}, subshell lists of one cluster, {MEMORY + INTERSECTION} cycles from a cell to the settle map; the "
        "hits are golden's. Rays overlap in cycles in which several subshells' are in flight.", "",
        "| scene | subshells | stages | cycles, barrier | cycles, depth 2 | barrier : depth 2 | rays overlap, barrier "
        "| rays overlap, depth 2 |", "|---" * 8 + "|", *rows, "",
        f"When stages of `{SCENE}` were in flight, run-ahead depth 2:", "", "```", *picture, "```", ""]
    output.parent.mkdir(parents=True, exist_ok=True)
    output.write_text("\n".join(lines))
    click.echo(f"wrote {output}")


if __name__ == "__main__":
    main()
