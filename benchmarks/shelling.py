"""Tests and cell steps of shelling.

``radiosity bench shelling`` writes out/bench/shelling.md: counts per ray from 16 points of the ceiling, and the cost of
sectors by number of clusters.
"""

import numpy as np

from benchmarks.ceiling import CELL, HEMISPHERE, POINTS, RATIO, SCENES, Ceiling
from benchmarks.report import benchmark, provenance, table, write_report
from golden.engine.cast.shelling import ShellingCounts
from golden.engine.config import Config
from radiosity.cli.console import console

CONFIG = Config()
MOST_TESTS, MOST_STEPS = {"lobby": 2.6, "room1627": 3.3}, 3.2
THESIS_TESTS = {"lobby": 2.6, "room1627": 4.1}
CLUSTERS = (1, 2, 4, 8, 16)


def work(name: str, ceiling: Ceiling) -> list:
    """Counts per ray, mean over all points."""
    total, shells = ShellingCounts(), []
    for point in range(len(ceiling.points)):
        _, (counts,) = ceiling.shelling.cast(ceiling.record(point))
        if counts.patches > len(ceiling.scene):
            raise SystemExit(f"error: {name}: a patch was fetched twice")
        total += counts
        shells.append(counts.shells)
    rays, points = total.rays, len(ceiling.points)
    return [name, len(ceiling.scene), f"{total.tests / rays:.2f}", MOST_TESTS.get(name, "-"),
            THESIS_TESTS.get(name, "-"), f"{total.in_windows / rays:.2f}", f"{total.cell_steps / rays:.2f}",
            f"{total.grid_rays / rays:.2f}", f"{total.cells / points:.0f}", f"{total.patches / points:.0f}",
            f"{total.edrc:.1f}", f"{np.mean(shells):.1f}"]


def sectors(name: str, ceiling: Ceiling) -> list[list]:
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
        rows.append([name, clusters, *means, f"{fetched:.0f}", *worst])
    return rows


@benchmark("shelling")
def main() -> None:
    """Count the work of shelling."""
    works, costs = [], []
    for name in SCENES:
        ceiling = Ceiling(name, CONFIG)
        works.append(work(name, ceiling))
        costs += sectors(name, ceiling)
        console().note(" ".join(map(str, works[-1])))
    write_report(
        "Shelling", provenance("numpy") + ".",
        "## Work",
        f"Cell {CELL}, hemispheres of {HEMISPHERE.azimuths} x {HEMISPHERE.polars} rays, mean over 16 points of the "
        f"ceiling. Tests per ray at most as given; cell steps per ray at most {MOST_STEPS}; "
        "cells, patches and shells per frustum.",
        table(["scene", "patches", "tests/ray k", "at most", "thesis", "in windows/ray", "cell steps/ray",
               "grid rays/ray", "cells", "patches found", "EDRC", "shells"], works),
        "## Sectors",
        f"The same hemispheres from points 4, 7, 10 and 13, cut in sections by a sparse casting from point 1 (ratio "
        f"{RATIO}); each cluster casts its own. Patches fetched: by all clusters. Worst: of the busiest cluster.",
        table(["scene", "clusters", "cell steps/ray", "grid rays/ray", "tests/ray", "patches fetched", "worst steps",
               "worst tests"], costs))
