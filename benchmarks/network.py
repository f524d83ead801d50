"""Links that requests for patches cross, in the networks that the thesis compares.

``radiosity bench network`` schedules a phase at ceiling point 1 of each scene for 2 to 64 clusters, casts from
points of the whole ceiling with it, sends every patch that a cluster requests and another holds over the network, and
writes out/bench/network.md.
"""

import click
import numpy as np

from benchmarks.ceiling import CELL, HEMISPHERE, RATIO, SCENES, Ceiling
from benchmarks.report import benchmark, provenance, table, write_report
from golden.engine.config import PRESETS
from golden.engine.memsys.bus.reference_strings import ReferenceStrings
from golden.engine.noc.topology import Topology
from radiosity.cli.console import console

CONFIG = PRESETS["paper"]
NETWORKS = ("ring", "illiac", "torus", "hypercube", "mesh")
CLUSTERS = (2, 4, 8, 16, 32, 64)
# Distances with a column of their own; the last one and all beyond.
NEAR = 5


def measure(ceiling: Ceiling, clusters: int, points: range) -> np.ndarray:
    """Cast from the points with the schedule of the first.

    Returns
    -------
    N x N int64: requests of each cluster for patches that each holds, its own ones on the diagonal.
    """
    plan = ceiling.plan(clusters)
    home, _ = plan.sets.residence(len(ceiling.geometry))
    between = np.zeros((clusters, clusters), dtype=np.int64)
    requests = ReferenceStrings.of(ceiling.shelling, [ceiling.record(point) for point in points],
                                   plan.partition.sections, plan.subshells)
    for frustum in requests.patches:
        for cluster, patches in enumerate(frustum):
            where = home[patches]
            between[cluster] += np.bincount(where[where >= 0], minlength=clusters)
    return between


def distances(between: np.ndarray, topology: Topology, processor: np.ndarray) -> np.ndarray:
    """Requests to other clusters by links that they pass."""
    away, remote = topology.hops[np.ix_(processor, processor)], between * (1 - np.eye(len(between), dtype=np.int64))
    return np.bincount(away.ravel(), weights=remote.ravel(), minlength=NEAR + 1).astype(np.int64)


def mean(counts: np.ndarray) -> float:
    """Links per request."""
    return float((counts * np.arange(len(counts))).sum() / max(1, counts.sum()))


def links(results: dict[tuple[str, int], np.ndarray]) -> list[list]:
    """Links per request and the share of requests to a neighbour, with the networks side by side."""
    rows = []
    for (name, clusters), between in results.items():
        counts = [distances(between, Topology.of(network, clusters), np.arange(clusters)) for network in NETWORKS]
        rows.append([name, clusters, *(f"{mean(one):.2f}, {one[1] / max(1, one.sum()):.3f}" for one in counts)])
    return rows


@benchmark("network", SCENES)
@click.option("--points", type=click.IntRange(1, 16), default=16, help="Cast from this many ceiling points in a phase.")
def main(scenes: tuple[str, ...], points: int) -> None:
    """Count the links that requests for patches take; SCENES default to lobby, room1627, cubes, man and phone."""
    results = {}
    for name in scenes:
        ceiling = Ceiling(name, CONFIG)
        for clusters in CLUSTERS:
            results[name, clusters] = measure(ceiling, clusters, range(points))
        console().note(f"{name}: {len(CLUSTERS)} sizes, {points} castings each")
    write_report(
        "Requests on the network",
        f"{HEMISPHERE.azimuths} x {HEMISPHERE.polars} rays, cell {CELL}, one ray of {RATIO} cast to prepare a phase at "
        f"ceiling point 1 of 16, {points} castings of the phase; a cluster requests each patch that it finds once a "
        f"casting. {provenance('numpy')}.",
        "## Links per request to another cluster, and the share of these requests that go to a neighbour",
        "Cluster i is node i.",
        table(["scene", "clusters", *NETWORKS], links(results)))
