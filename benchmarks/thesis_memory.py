"""The thesis' patch requests by memory (figures 6.5 and 6.6), counted.

``radiosity bench thesis_memory`` schedules a phase at ceiling point 1 of each scene for 1 to 8 clusters, casts from
that point and then from point 2, and counts which memory serves each patch that a cluster requests. It writes
out/bench/thesis_memory.md. Nothing is set for a scene.
"""

from collections.abc import Sequence
from itertools import chain, zip_longest

import numpy as np

from benchmarks.ceiling import CELL, HEMISPHERE, RATIO, SCENES, Ceiling
from benchmarks.grades import BAND, grade_of
from benchmarks.report import benchmark, provenance, table, write_report
from golden.engine.config import PRESETS
from golden.engine.memsys.bus.cache import Cache
from golden.engine.memsys.bus.cache_policy import CachePolicy
from golden.engine.memsys.bus.reference_strings import ReferenceStrings
from radiosity.cli.console import console

__all__ = ["by_memory", "grade_growth", "grade_share", "in_turn", "requests_by_memory"]

_CLUSTERS, _POINTS = (1, 2, 4, 8), (0, 1)
# Of the share that is most of all.
_MOST = 0.5
_MEMORIES = "own", "clusters", "cache", "main memory"


def in_turn(strings: Sequence[Sequence[int]]) -> list[tuple[int, int]]:
    """Requests of clusters that each make one in turn: cluster and patch."""
    requests = chain.from_iterable(zip_longest(*([(cluster, patch) for patch in string]
                                                 for cluster, string in enumerate(strings))))
    return [request for request in requests if request is not None]


def by_memory(strings: Sequence[Sequence[int]], home: np.ndarray, cache: Cache) -> tuple[int, int, int, int]:
    """Requests that a cluster's own memory serves, those of other clusters, the cache, and main memory.

    Parameters
    ----------
    strings
        The patches that each cluster requests, in order.
    home
        N int64: the cluster that holds each patch, -1 if none does.
    cache
        The cache that all clusters share; what it holds stays.
    """
    own = others = hits = misses = 0
    for cluster, patch in in_turn(strings):
        if home[patch] == cluster:
            own += 1
        elif home[patch] >= 0:
            others += 1
        elif cache.access([patch])[0][0]:
            hits += 1
        else:
            misses += 1
    return own, others, hits, misses


def grade_growth(many: int, few: int) -> str:
    """What has become of a number that is the same for few and for many clusters in the thesis."""
    return grade_of(abs(many - few) <= BAND * few)


def grade_share(share: float, before: float) -> str:
    """What has become of the cache's share of the requests for patches that no cluster holds: most; or it grows."""
    return grade_of(share > _MOST, share > before)


def requests_by_memory(ceiling: Ceiling, clusters: int, lines: int) -> list[tuple[int, int, int, int]]:
    """Requests by memory from each point, see `by_memory`, with a cache of so many lines that is empty at first."""
    plan = ceiling.plan(clusters)
    home = plan.sets.residence(len(ceiling.geometry))[0]
    cache = Cache(CachePolicy.LFU, lines=lines, lfu_lines=lines)
    requests = ReferenceStrings.of(ceiling.shelling, [ceiling.record(point) for point in _POINTS],
                                   plan.partition.sections, plan.subshells)
    return [by_memory(strings, home, cache) for strings in requests.patches]


def _share(counts):
    """The cache's share of the requests that no cluster's memory serves."""
    _, _, hits, misses = counts
    return hits / max(1, hits + misses)


@benchmark("thesis_memory", SCENES, only=True)
def main(scenes) -> None:
    """Count patch requests by memory; SCENES default to lobby, room1627, cubes, man and phone."""
    rows, grades, lines = [], [], PRESETS["thesis"].memsys.patch_lines
    for scene in dict.fromkeys(scenes):
        ceiling, found = Ceiling(scene, PRESETS["thesis"]), {}
        for clusters in _CLUSTERS:
            found[clusters] = requests_by_memory(ceiling, clusters, lines)
            rows.append([f"`{scene}`", clusters, *(f"{count:,}" for point in found[clusters] for count in point)])
            console().note(f"{scene}, {clusters} clusters: {found[clusters]}")
        few, many = (found[clusters][0][-1] for clusters in (_CLUSTERS[0], _CLUSTERS[-1]))
        before, share = (_share(point) for point in found[_CLUSTERS[-1]])
        whole = 1 << (len(ceiling.geometry) - 1).bit_length()
        grades.append([f"`{scene}`", f"{many / max(1, few):.2f}", grade_growth(many, few), f"{before:.2f}",
                       f"{share:.2f}", grade_share(share, before),
                       f"{_share(requests_by_memory(ceiling, _CLUSTERS[-1], whole)[1]):.2f}"])
    write_report(
        "Patch requests by memory",
        f"{provenance('numpy')}; preset thesis, {HEMISPHERE.azimuths} x {HEMISPHERE.polars} rays, cell {CELL}, "
        f"sections and resident sets by a sparse casting of one ray of {RATIO} from point 1, a cache of {lines} "
        "patches that is empty before point 1.",
        table(["scene", "clusters", *(f"{memory}, point {point + 1}" for point in _POINTS for memory in _MEMORIES)],
              rows),
        table(["scene", "main memory, point 1, 8 : 1", "grade", "share of the cache, point 1", "point 2",
               "grade of shares",
               "point 2, all patches cached"], grades))
