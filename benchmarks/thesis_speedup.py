"""The thesis' speedup and efficiency against clusters (figures 6.10, 6.12 and 6.13), simulated.

``radiosity bench thesis_speedup`` simulates the thesis' machine with 1 to 16 clusters: a frustum from ceiling point 1,
which the schedule is made at, with an empty cache; and then one from point 2. It writes out/bench/thesis_speedup.md,
with a grade for each number that the thesis' text has of these figures. Nothing is set for a scene.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain

import click

from benchmarks.ceiling import CELL, SCENES
from benchmarks.grades import BAND, grade, grade_of
from benchmarks.machine_cuts import prepare_cut, simulate_cut, thesis_config
from benchmarks.report import benchmark, provenance, table, write_report
from benchmarks.thesis_memory import in_turn
from radiosity.cli.console import console

__all__ = ["Speed", "grade_linear", "grades_of"]

# Clusters; those of speedups and of the grades.
_CLUSTERS, _ONE, _AT = (1, 2, 4, 8, 16), 1, 8
# The thesis has 196,608 rays; azimuths and polar angles of hemispheres are powers of two here.
_RAYS = (1024, 256)
# Cycles in which a memory has a patch read, and a cache that holds nearly all patches of each scene.
_LOCAL, _ALL = 10, {"memsys.cache_policy": "lru", "memsys.patch_lines": 4096}
# Efficiency of `man` on 8 clusters, at the reference point and at point 2; the share of a linear speedup that is
# nearly linear: that efficiency.
_COLD, _WARM = 0.4, 0.8
_CACHES = ("64 lines", "all patches cached")


@dataclass(frozen=True, kw_only=True)
class Speed:
    """A frustum on several clusters.

    Parameters
    ----------
    cycles
        Of the slowest cluster.
    speedup
        To the cycles of one cluster.
    efficiency
        Tests in each cycle of a cluster.
    """

    cycles: int
    speedup: float
    efficiency: float


def grade_linear(speedup: float, before: float, clusters: int) -> str:
    """What has become of a speedup that is nearly linear: so it is; or larger than that before."""
    return grade_of(speedup >= _WARM * clusters, speedup > before)


def _grade_efficiency(simulated, thesis):
    """Of an efficiency: within 15 %, or not. All are below 1, so that is no shape."""
    return grade_of(abs(simulated / thesis - 1) <= BAND)


def grades_of(found: dict[int, Sequence[Speed]]) -> list[tuple[str, str, list[tuple[float, str]]]]:
    """What the thesis' text has of `man`, each with the simulated numbers and their grades, one for each cache.

    Parameters
    ----------
    found
        By clusters: from point 1 with an empty cache, then from point 2 with each cache.
    """
    cold, *warm = found[_AT]
    first, last = (found[clusters][0].speedup / clusters for clusters in (min(found), max(found)))
    return [
        (f"speedup on {_AT} clusters, point 2", "nearly linear",
         [(one.speedup, grade_linear(one.speedup, cold.speedup, _AT)) for one in warm]),
        (f"efficiency on {_AT} clusters, point 1", f"{_COLD}",
         [(cold.efficiency, _grade_efficiency(cold.efficiency, _COLD))] * len(warm)),
        (f"efficiency on {_AT} clusters, point 2", f"{_WARM}",
         [(one.efficiency, _grade_efficiency(one.efficiency, _WARM)) for one in warm]),
        (f"efficiency, point 2 : point 1, {_AT} clusters", f"{_WARM / _COLD:.2f}",
         [(one.efficiency / cold.efficiency, grade(one.efficiency / cold.efficiency, _WARM / _COLD)) for one in warm]),
        ("speedup for each cluster, point 1, most : fewest clusters", "< 1",
         [(last / first, grade_of(last < first))] * len(warm))]


def _simulated(scene, nodes):
    """By clusters: cycles and efficiency of a frustum from point 1, and then from point 2 with each cache."""
    found = {}
    for clusters in nodes:
        config = thesis_config(clusters, rays=_RAYS)
        caches = [config, config.replace(_ALL)]
        first, second = (prepare_cut(scene, config, cell=CELL, rays=_RAYS, point=point) for point in (0, 1))
        kept = [patch for _, patch in in_turn([trace.patch for trace in first.traces]) if first.home[patch] < 0]
        cycles = [max(one.cycles for one in simulate_cut(prepared, cache, local=_LOCAL, kept=before))
                  for prepared, cache, before in ((first, config, ()), *((second, cache, kept) for cache in caches))]
        found[clusters] = [(each, tests / (clusters * each)) for each, tests in zip(
            cycles, (int(prepared.tests.sum()) for prepared in (first, second, second)), strict=True)]
        console().note(f"{scene}, {clusters} clusters: {found[clusters]}")
    return {clusters: [Speed(cycles=cycles, speedup=one[0] / cycles, efficiency=efficiency)
                       for (cycles, efficiency), one in zip(casts, found[_ONE], strict=True)]
            for clusters, casts in found.items()}


@benchmark("thesis_speedup", SCENES, only=True)
@click.option("--nodes", type=click.IntRange(1), multiple=True, default=_CLUSTERS, show_default=True,
              help="Simulate this many clusters, beside 1 and 8; may be repeated.")
def main(scenes, nodes) -> None:
    """Simulate the thesis' machine on 1 to 16 clusters; SCENES default to lobby, room1627, cubes, man and phone."""
    found = {scene: _simulated(scene, sorted({_ONE, _AT, *nodes})) for scene in dict.fromkeys(scenes)}
    rows = [[f"`{scene}`", clusters, *chain.from_iterable(
        (f"{one.cycles:,}", f"{one.speedup:.2f}", f"{one.efficiency:.2f}") for one in speeds)]
        for scene, each in found.items() for clusters, speeds in each.items()]
    grades = [["`man`", what, expected, *chain.from_iterable((f"{number:.2f}", text) for number, text in each)]
              for what, expected, each in (grades_of(found["man"]) if "man" in found else ())]
    of = ("point 1", *(f"point 2, {cache}" for cache in _CACHES))
    write_report(
        "Speedup and efficiency of the thesis' machine, simulated",
        f"{provenance('numpy')}; preset thesis, {_RAYS[0]} x {_RAYS[1]} rays, cell {CELL}, a patch read in {_LOCAL} "
        "cycles, sections and resident sets by a sparse casting from point 1. The cache is empty before point 1 and "
        "keeps its patches for point 2.",
        table(["scene", "clusters", *(f"{number}, {cast}" for cast in of for number in (
            "cycles", "speedup", "efficiency"))], rows),
        table(["scene", "number", "thesis", *chain.from_iterable((cache, f"grade of {cache}") for cache in _CACHES)],
              grades))
