"""Miss ratios of the caches, and the resident set beside a cache of as many bytes.

``radiosity bench caches`` casts hemispheres from ceiling points of each scene with the schedule of a phase and gives
the clusters' requests to golden's caches. It writes out/bench/caches.md and a chart for each scene, the thesis'
figures 1.13 and 1.14. `tb/memsys/bus/test_cache_strings.py` shows that the hardware's cache gives the same answers.
"""

import numpy as np

from benchmarks.ceiling import CELL, HEMISPHERE, POINTS, SCENES, Ceiling
from benchmarks.report import benchmark, provenance, table, write_chart, write_report
from golden.engine.config import PRESETS, Config
from golden.engine.memsys.bus.cache import Cache
from golden.engine.memsys.bus.cache_policy import CachePolicy
from golden.engine.memsys.bus.reference_strings import ReferenceStrings, interleaved
from golden.engine.schedule.phase import Schedule
from radiosity.charts.chart import Line
from radiosity.cli.console import console

__all__ = ["cast_strings"]

CONFIG = PRESETS["paper"]
CLUSTERS = 4
SIZES = tuple(1 << bits for bits in range(3, 13))
NAMES = {CachePolicy.DIRECT: "direct", CachePolicy.LFU: "fully associative, LFU", CachePolicy.LRU: "4-way, LRU"}
# What the resident set is compared with: lines of a cluster's own cache.
OWN_LINES = (32, 64, 128, 256, 512)
# Requests, and lines, of a shorter table.
FIRST, FIRST_LINES = 3000, (16, 64)
# Bits of a key. A patch is five beats of 72 bits, wherever it is.
KEY_BITS, PATCH_BITS = 16, 5 * 72


def cast_strings(name: str, config: Config, clusters: int, points: tuple[int, ...] = POINTS, **ceiling) -> tuple[
        Schedule, ReferenceStrings, dict[str, np.ndarray]]:
    """A phase, what its clusters request in castings, frustum by frustum, and all cells and all patches of that.

    Parameters
    ----------
    name, config, ceiling
        See `Ceiling`.
    clusters, points
        Clusters of the phase, which is scheduled at point 0, and the points of its castings.
    """
    made = Ceiling(name, config, **ceiling)
    plan = made.plan(clusters)
    requests = ReferenceStrings.of(made.shelling, [made.record(point) for point in points], plan.partition.sections)
    return plan, requests, {"cells": interleaved(requests.cells), "patches": interleaved(requests.patches)}


def misses(policy: CachePolicy, lines: int, keys: np.ndarray) -> int:
    """Of one string, from an empty cache on."""
    cache = Cache(policy, lines=lines, lfu_lines=lines)
    cache.access(keys)
    return cache.misses


def ratios(string: np.ndarray) -> dict[CachePolicy, list[float]]:
    """Miss ratios under each policy, size by size."""
    return {policy: [misses(policy, lines, string) / max(1, len(string)) for lines in SIZES] for policy in NAMES}


def beginning(name: str, string: np.ndarray) -> list:
    """A row of miss ratios of the first requests for patches, which the tests replay in hardware."""
    first = string[:FIRST]
    return [name, *(f"{misses(policy, lines, first) / len(first):.3f}" for lines in FIRST_LINES for policy in NAMES)]


def cache_bits(lines: int) -> int:
    """Memory of a 4-way cache of patches: records with their errors, keys, and what a set knows of its ways."""
    memsys = CONFIG.memsys
    sets = lines // memsys.cache_ways
    key = KEY_BITS - (sets.bit_length() - 1)
    pairs = memsys.cache_ways * (memsys.cache_ways - 1) // 2
    return lines * (PATCH_BITS + 1 + key + 1) + sets * (memsys.cache_generation_bits + pairs)


def resident(name: str, plan: Schedule, patches: list[list[np.ndarray]]) -> list[list]:
    """Table rows: share of a cluster's requests that its own memory or cache of as many bytes answers."""
    rows = []
    home = np.full(1 + max(int(string.max()) for frustum in patches for string in frustum if len(string)), -1)
    for lines in OWN_LINES:
        capacity = cache_bits(lines) // PATCH_BITS
        frequency, own, near, cached, total = plan.found.frequency, 0, 0, 0, 0
        home[:] = -1
        for cluster, held in enumerate(plan.sets.patches):
            kept = held[np.argsort(-frequency[held], kind="stable")[:capacity]]
            home[kept[kept < len(home)]] = cluster
        for cluster in range(CLUSTERS):
            string = np.concatenate([frustum[cluster] for frustum in patches])
            own += int((home[string] == cluster).sum())
            near += int((home[string] >= 0).sum())
            cached += len(string) - misses(CachePolicy.LRU, lines, string)
            total += len(string)
        rows.append([name, lines, cache_bits(lines) // 8, capacity,
                     *(f"{count / total:.3f}" for count in (own, near, cached))])
    return rows


@benchmark("caches", SCENES)
def main(scenes: tuple[str, ...]) -> None:
    """Write tables and charts for SCENES (default: the five of the thesis)."""
    rows, sets, firsts = [], [], []
    for name in scenes:
        plan, requests, joined = cast_strings(name, CONFIG, CLUSTERS)
        curves = {what: ratios(string) for what, string in joined.items()}
        rows += [[name, what, len(string), len(np.unique(string)), NAMES[policy], *(f"{value:.3f}" for value in values)]
                 for what, string in joined.items() for policy, values in curves[what].items()]
        sets += resident(name, plan, requests.patches)
        firsts.append(beginning(name, joined["patches"]))
        lines = [Line(name=f"{what}: {NAMES[policy]}", x=np.log2(SIZES), y=np.array(values))
                 for what, by_policy in curves.items() for policy, values in by_policy.items()]
        write_chart(f"caches-{name}", lines, title=f"{name}: miss ratio", x_name="logarithm of the lines",
                    y_name="miss ratio", y_top=1.0)
        console().note(f"{name}: {len(joined['patches'])} requests for patches")
    write_report(
        "Caches",
        f"{provenance('numpy')}; hemispheres of {len(HEMISPHERE)} rays from ceiling points "
        f"{', '.join(str(point + 1) for point in POINTS)}, one after the other, {CLUSTERS} clusters whose requests "
        f"take turns, cell {CELL}.",
        "## Miss ratio against lines",
        table(["scene", "string", "requests", "different", "placement", *SIZES], rows),
        f"## Miss ratio of the first {FIRST} requests for patches",
        table(["scene", *(f"{lines}: {NAMES[policy]}" for lines in FIRST_LINES for policy in NAMES)], firsts),
        "## Resident set and cache of equal bytes",
        "Share of the clusters' requests for patches that are answered: by the cluster's own resident set; by that of "
        "any cluster; by a 4-way LRU cache of the cluster's own, never emptied.",
        table(["scene", "lines", "bytes", "patches of the set", "own set", "any set", "own cache"], sets))
