"""Links that requests for patches cross, in the networks that the thesis compares.

``radiosity bench network`` schedules a phase at ceiling point 1 of each scene for 2 to 64 clusters, casts from
points of the whole ceiling with it, sends every patch that a cluster requests and another holds over the network, and
writes out/bench/network.md: the thesis' figures 5.5 to 5.7 as tables, for five scenes.
"""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import click
import numpy as np

from benchmarks.ceiling import CELL, HEMISPHERE, RATIO, SCENES, Ceiling
from benchmarks.report import output_option, provenance, write_report
from golden.engine.config import PRESETS
from golden.engine.noc.topology import Topology
from golden.engine.schedule.assignment import simple
from radiosity.cli.console import console

CONFIG = PRESETS["paper"]
NETWORKS = ("ring", "illiac", "torus", "hypercube", "mesh")
CLUSTERS = (2, 4, 8, 16, 32, 64)
# Distances with a column of their own; the last one and all beyond.
NEAR = 5


@dataclass(frozen=True)
class Traffic:
    """Requests of all castings of a phase.

    Parameters
    ----------
    between
        N x N: requests of each cluster to each other one for a patch that it holds; on the diagonal its own patches.
    """

    between: np.ndarray

    @property
    def remote(self) -> np.ndarray:
        """Requests that pass the network."""
        return self.between * (1 - np.eye(len(self.between), dtype=np.int64))


def measure(ceiling: Ceiling, clusters: int, points: range) -> Traffic:
    """Cast from the points with the schedule of the first."""
    plan = ceiling.plan(clusters)
    home, _ = plan.sets.residence(len(ceiling.geometry))
    between = np.zeros((clusters, clusters), dtype=np.int64)
    for point in points:
        requests = []
        ceiling.shelling.cast(ceiling.record(point), plan.partition.sections, plan.subshells, requests=requests)
        for cluster, requested in enumerate(requests):
            where = home[requested.patches]
            between[cluster] += np.bincount(where[where >= 0], minlength=clusters)
    return Traffic(between)


def distances(traffic: Traffic, topology: Topology, processor: np.ndarray) -> np.ndarray:
    """Remote requests by links that they pass."""
    away = topology.hops[np.ix_(processor, processor)]
    return np.bincount(away.ravel(), weights=traffic.remote.ravel(), minlength=NEAR + 1).astype(np.int64)


def mean(counts: np.ndarray) -> float:
    """Links per request."""
    return float((counts * np.arange(len(counts))).sum() / max(1, counts.sum()))


def proximity() -> list[str]:
    """Figure 5.7."""
    networks = {name: Topology.of(name, 16) for name in NETWORKS}
    most = max(network.hops.max() for network in networks.values())
    rows = [[f"{np.mean((network.hops == distance).sum(axis=1)):g}" for distance in range(1, most + 1)]
            for network in networks.values()]
    return ["## Nodes at each distance, 16 nodes (thesis: figure 5.7)", "",
            "A mesh has borders: the mean of its nodes.", "",
            "| links | " + " | ".join(map(str, range(1, most + 1))) + " | mean | pairs of links |",
            "|---" * (most + 3) + "|",
            *(f"| {name} | " + " | ".join(row) + f" | {network.hops.sum() / 240:.2f} | {len(network.links) // 2} |"
              for (name, network), row in zip(networks.items(), rows, strict=True)), ""]


def hop_counts(results: dict[tuple[str, int], Traffic], castings: int) -> list[str]:
    """Figures 5.5 and 5.6."""
    lines = ["## Links that the requests of a casting pass (thesis: figures 5.5 and 5.6)", "",
             "Cluster i is node i, as in the thesis. In brackets divided by the network's links, the thesis' bound for "
             "cycles.", "", "| scene | clusters | requests | " + " | ".join(NETWORKS) + " |",
             "|---" * (3 + len(NETWORKS)) + "|"]
    for (name, clusters), traffic in results.items():
        cells = []
        for network in NETWORKS:
            topology = Topology.of(network, clusters)
            counts = distances(traffic, topology, simple(clusters))
            total = (counts * np.arange(len(counts))).sum() / castings
            cells.append(f"{total:.0f} ({total / len(topology.links):.1f})")
        lines.append(f"| {name} | {clusters} | {traffic.remote.sum() / castings:.0f} | " + " | ".join(cells) + " |")
    return [*lines, ""]


def links(results: dict[tuple[str, int], Traffic]) -> list[str]:
    """Links per request and the share of requests to a neighbour, with the networks side by side."""
    lines = ["## Links per request to another cluster, and the share of these requests that go to a neighbour", "",
             "Cluster i is node i.", "",
             "| scene | clusters | " + " | ".join(NETWORKS) + " |", "|---" * (2 + len(NETWORKS)) + "|"]
    for (name, clusters), traffic in results.items():
        cells = []
        for network in NETWORKS:
            counts = distances(traffic, Topology.of(network, clusters), simple(clusters))
            cells.append(f"{mean(counts):.2f}, {counts[1] / max(1, counts.sum()):.3f}")
        lines.append(f"| {name} | {clusters} | {' | '.join(cells)} |")
    return [*lines, ""]


def claims(results: dict[tuple[str, int], Traffic]) -> list[str]:
    """What the thesis says of its figures, whose numbers are lost, and where it is so here."""

    def total(traffic, network, clusters):
        counts = distances(traffic, Topology.of(network, clusters), simple(clusters))
        return int((counts * np.arange(len(counts))).sum())

    four = NETWORKS[:4]
    statements: dict[str, tuple[Callable, tuple[int, ...]]] = {
        "most requests go to a neighbour (torus)": (
            lambda traffic, clusters: distances(traffic, Topology.of("torus", clusters), simple(clusters))[1]
            > traffic.remote.sum() / 2, CLUSTERS),
        "the ring needs more than every other one": (
            lambda traffic, clusters: all(total(traffic, "ring", clusters) > total(traffic, other, clusters)
                                          for other in four[1:]), (16, 32, 64)),
        "the hypercube is the best of 32 and 64": (
            lambda traffic, clusters: all(total(traffic, "hypercube", clusters) <= total(traffic, other, clusters)
                                          for other in four), (32, 64)),
        "Illiac or torus is the best of up to 8": (
            lambda traffic, clusters: min(total(traffic, other, clusters) for other in ("illiac", "torus"))
            <= min(total(traffic, other, clusters) for other in four), (2, 4, 8))}
    scenes = list(dict.fromkeys(scene for scene, _ in results))
    lines = ["## What the thesis says of its figures", "",
             "Its figures are pictures without numbers. Of its statements: the numbers of clusters for which they hold "
             "here, of those that they are made for.", "", "| statement | clusters | " + " | ".join(scenes) + " |",
             "|---" * (2 + len(scenes)) + "|"]
    for statement, (holds, sizes) in statements.items():
        sizes = [clusters for clusters in sizes if any(key[1] == clusters for key in results)]
        cells = [", ".join(str(clusters) for clusters in sizes if holds(results[scene, clusters], clusters)) or "none"
                 for scene in scenes]
        lines.append(f"| {statement} | {', '.join(map(str, sizes))} | " + " | ".join(cells) + " |")
    return [*lines, ""]


@click.command()
@click.argument("scenes", nargs=-1)
@click.option("--points", type=click.IntRange(1, 16), default=16, help="Cast from this many ceiling points in a phase.")
@output_option("network")
def main(scenes: tuple[str, ...], points: int, output: Path) -> None:
    """Count the links that requests for patches take; SCENES default to lobby, room1627, cubes, man and phone."""
    results = {}
    for name in scenes or SCENES:
        ceiling = Ceiling(name, CONFIG)
        for clusters in CLUSTERS:
            results[name, clusters] = measure(ceiling, clusters, range(points))
        console().note(f"{name}: {len(CLUSTERS)} sizes, {points} castings each")
    write_report(output, [
        "# Requests on the network", "",
        f"{HEMISPHERE.azimuths} x {HEMISPHERE.polars} rays, cell {CELL}, one ray of {RATIO} cast to prepare a phase at "
        f"ceiling point 1 of 16, {points} castings of the phase; a cluster requests each patch that it finds once a "
        f"casting. {provenance('numpy')}.", "",
        *hop_counts(results, points), *links(results), *claims(results), *proximity()])
