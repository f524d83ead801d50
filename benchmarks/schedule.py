"""Resident sets beside tables 6.5 and 6.6 of the thesis, and the balance of work between clusters.

``radiosity bench schedule`` schedules a phase at ceiling point 1 of each scene, casts from other points with it, and
writes out/bench/schedule.md: the thesis' tables 6.5 and 6.6, and the balance over 2 to 16 clusters.
"""

import numpy as np

from benchmarks.ceiling import CELL, HEMISPHERE, POINTS, SCENES, Ceiling
from benchmarks.report import benchmark, table, write_report
from golden.engine.config import PRESETS
from golden.engine.schedule.low_density import low_density
from golden.engine.schedule.usage import cumulative_frequency, effectiveness, usage_order
from radiosity.cli.console import console

CONFIG = PRESETS["paper"]
RATIOS = (16, 64, 256)
CLUSTERS = (2, 4, 8, 16)
# The capacity of a section over the mean number of rays.
CAPACITY = 1.4
# Shen 1993, tables 6.5 and 6.6: N', and the share of the references at the points.
THESIS = {
    "lobby": {16: (142, (0.8934, 0.9281, 0.913, 0.9105)), 64: (97, (0.7919, 0.836, 0.8574, 0.7985)),
              256: (80, (0.7122, 0.7367, 0.816, 0.7367))},
    "room1627": {16: (855, (0.8549, 0.8036, 0.8672, 0.807)), 64: (325, (0.7671, 0.7628, 0.8163, 0.6882)),
                 256: (190, (0.6363, 0.713, 0.6563, 0.5632))},
}


def sparse(ceiling: Ceiling, ratio: int):
    """The sparse casting at the reference point."""
    return low_density(ceiling.record(0), ceiling.geometry, ceiling.shelling.table, CONFIG, ratio=ratio)


def usage(name: str, ceiling: Ceiling) -> list[list]:
    """Rows of table 6.5 or 6.6 of the thesis, with ours behind them."""
    dense, rows = [ceiling.references(point) for point in POINTS], []
    for ratio in RATIOS:
        found = sparse(ceiling, ratio)
        order = usage_order(found.frequency)
        count, theirs = THESIS[name][ratio]
        kept = min(count, len(found.patches))
        for label, size, values in (
                ("thesis", count, theirs),
                ("all found", len(found.patches), [cumulative_frequency(one, found.patches) for one in dense]),
                ("most used, the thesis' N'", kept, [cumulative_frequency(one, order[:kept]) for one in dense]),
                ("best of that size", kept, [cumulative_frequency(one, usage_order(one)[:kept]) for one in dense]),
                ("E(k) there", kept, [effectiveness(one, found.frequency)[kept - 1] for one in dense])):
            rows.append([ratio, label, size, *(f"{value:.3f}" for value in values)])
    return rows


def balance(name: str, ceiling: Ceiling, factor: float | None) -> list[list]:
    """Largest over mean: tests estimated and true, rays, cell steps, by clusters; and with equal sections."""
    rows = []
    for clusters in CLUSTERS:
        mean = len(HEMISPHERE) // clusters
        equal = _tests(ceiling, ceiling.plan(clusters, ratio=RATIOS[1], ray_capacity=mean))[0]
        for ratio in RATIOS:
            plan = ceiling.plan(clusters, ratio=ratio, ray_capacity=factor and int(factor * mean))
            tests, rays, steps = _tests(ceiling, plan)
            others = [_tests(ceiling, plan, point)[0] for point in POINTS]
            rows.append([
                name, clusters, ratio, f"{_over(plan.estimated):.2f}", f"{_over(tests):.2f}",
                f"{np.mean([_over(other) for other in others]):.2f}", f"{_over(equal):.2f}", f"{_over(rays):.2f}",
                f"{_over(steps):.2f}", tests.max(), steps.max()])
    return rows


def _tests(ceiling, plan, point=1):
    _, counts = ceiling.shelling.cast(ceiling.record(point), plan.partition.sections)
    return [np.array([getattr(one, name) for one in counts]) for name in ("tests", "rays", "cell_steps")]


def _over(values):
    return values.max() / values.mean()


@benchmark("schedule", SCENES)
def main(scenes: tuple[str, ...]) -> None:
    """Compare the scheduler with the thesis' tables; SCENES default to lobby, room1627, cubes, man and phone."""
    ceilings, parts = {name: Ceiling(name, CONFIG) for name in scenes}, []
    for name, ceiling in ceilings.items():
        if name in THESIS:
            parts += [f"### {name}, {len(ceiling.geometry)} patches",
                      table(["ratio", "", "N'", *(f"CUF {point + 1}" for point in POINTS)], usage(name, ceiling))]
            console().note(f"{name}: cumulative usage frequency")
    for factor, title in ((None, "any number of rays in a section"),
                          (CAPACITY, f"at most {CAPACITY} x mean rays in a section")):
        parts += [f"## Balance, largest : mean, {title}", table(
            ["scene", "clusters", "ratio", "tests, estimated", "tests", "tests, mean of points 4, 7, 10, 13",
             "tests, equal sections", "rays", "cell steps", "most tests", "most cell steps"],
            [row for name, ceiling in ceilings.items() for row in balance(name, ceiling, factor)])]
        console().note(f"balance, {title}")
    write_report(
        "The host's scheduler",
        f"{HEMISPHERE.azimuths} x {HEMISPHERE.polars} rays, cell {CELL}, 16 points on the ceiling numbered row by "
        "row, reference point 1.", "## Cumulative usage frequency (thesis: tables 6.5 and 6.6)", *parts)
