"""Tests and cell steps of shelling.

``radiosity bench shelling`` writes out/bench/shelling.md: counts per ray from 16 points of the ceiling, and the cost of
sectors by number of clusters.
"""

from pathlib import Path

import click
import numpy as np

from benchmarks.ceiling import CELL, HEMISPHERE, POINTS, RATIO, SCENES, Ceiling
from benchmarks.report import output_option, provenance, write_report
from golden.engine.cast.shelling import ShellingCounts
from golden.engine.config import Config
from radiosity.cli.console import console

CONFIG = Config()
MOST_TESTS, MOST_STEPS = {"lobby": 2.6, "room1627": 3.3}, 3.2
THESIS_TESTS = {"lobby": 2.6, "room1627": 4.1}
CLUSTERS = (1, 2, 4, 8, 16)


def work(name: str, ceiling: Ceiling) -> str:
    """Counts per ray, mean over all points."""
    total, shells = ShellingCounts(), []
    for point in range(len(ceiling.points)):
        _, (counts,) = ceiling.shelling.cast(ceiling.record(point))
        if counts.patches > len(ceiling.scene):
            raise SystemExit(f"error: {name}: a patch was fetched twice")
        total += counts
        shells.append(counts.shells)
    rays, points = total.rays, len(ceiling.points)
    most = f"{MOST_TESTS[name]}" if name in MOST_TESTS else "-"
    return (f"| {name} | {len(ceiling.scene)} | {total.tests / rays:.2f} | {most} | {THESIS_TESTS.get(name, '-')} "
            f"| {total.in_windows / rays:.2f} | {total.cell_steps / rays:.2f} | {total.grid_rays / rays:.2f} "
            f"| {total.cells / points:.0f} | {total.patches / points:.0f} | {total.edrc:.1f} | {np.mean(shells):.1f} |")


def sectors(name: str, ceiling: Ceiling) -> list[str]:
    """What a frustum costs when its sections are cast each by itself."""
    rows = []
    for clusters in CLUSTERS:
        plan = ceiling.plan(clusters)
        counts = [ceiling.shelling.cast(ceiling.record(point), sectors=plan.partition.sections)[1] for point in POINTS]
        rays = sum(cluster.rays for frustum in counts for cluster in frustum)
        means = [f"{sum(getattr(cluster, field) for frustum in counts for cluster in frustum) / rays:.2f}"
                 for field in ("cell_steps", "grid_rays", "tests")]
        fetched = np.mean([sum(cluster.patches for cluster in frustum) for frustum in counts])
        worst = [f"{np.mean([max(getattr(cluster, field) for cluster in frustum) for frustum in counts]):.0f}"
                 for field in ("cell_steps", "tests")]
        rows.append(f"| {name} | {clusters} | {' | '.join(means)} | {fetched:.0f} | {' | '.join(worst)} |")
    return rows


@click.command()
@output_option("shelling")
def main(output: Path) -> None:
    """Count the work of shelling."""
    ceilings = {name: Ceiling(name, CONFIG) for name in SCENES}
    works = [work(name, ceiling) for name, ceiling in ceilings.items()]
    costs = [row for name, ceiling in ceilings.items() for row in sectors(name, ceiling)]
    lines = [
        "# Shelling", "", provenance("numpy") + ".", "",
        "## Work", "",
        f"Cell {CELL}, hemispheres of {HEMISPHERE.azimuths} x {HEMISPHERE.polars} rays, mean over 16 points of the "
        f"ceiling. Tests per ray at most as given; cell steps per ray at most {MOST_STEPS}; "
        "cells, patches and shells per frustum.", "",
        "| scene | patches | tests/ray k | at most | thesis | in windows/ray | cell steps/ray | grid rays/ray | cells "
        "| patches found | EDRC | shells |", "|---" * 12 + "|", *works, "",
        "## Sectors", "",
        f"The same hemispheres from points 4, 7, 10 and 13, cut in sections by a sparse casting from point 1 (ratio "
        f"{RATIO}); each cluster casts its own. Patches fetched: by all clusters. Worst: of the busiest cluster.", "",
        "| scene | clusters | cell steps/ray | grid rays/ray | tests/ray | patches fetched | worst steps "
        "| worst tests |",
        "|---" * 8 + "|", *costs, "",
    ]
    console().note("\n".join(works + costs))
    write_report(output, lines)
