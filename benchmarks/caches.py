"""Miss ratios of the caches, and the resident set beside a cache of as many bytes.

``radiosity bench caches`` casts hemispheres from ceiling points of each scene with the schedule of a phase and gives
the clusters' requests to golden's caches. It writes out/bench/caches.md and a chart for each scene, the thesis'
figures 1.13 and 1.14. `tb/memsys/bus/test_cache_strings.py` shows that the hardware's cache gives the same answers.
"""

from pathlib import Path

import click
import numpy as np

from benchmarks.cache_strings import POINTS, SCENES, Strings, cast_strings
from benchmarks.report import output_option, provenance, write_report
from golden.cast.hemisphere import Hemisphere
from golden.engine.config import PRESETS
from golden.engine.memsys.bus.cache import Cache
from golden.engine.memsys.bus.cache_policy import CachePolicy
from radiosity.charts.chart import Line, line_figure, write_figure
from radiosity.cli.console import console

CONFIG = PRESETS["paper"]
HEMISPHERE, CELL, CLUSTERS = Hemisphere(256, 64), 0.0625, 4
SIZES = tuple(1 << bits for bits in range(3, 13))
NAMES = {CachePolicy.DIRECT: "direct", CachePolicy.LFU: "fully associative, LFU", CachePolicy.LRU: "4-way, LRU"}
# What the resident set is compared with: lines of a cluster's own cache.
OWN_LINES = (32, 64, 128, 256, 512)
# Requests, and lines, of a shorter table.
FIRST, FIRST_LINES = 3000, (16, 64)
# Bits of a key. A patch is five beats of 72 bits, wherever it is.
KEY_BITS, PATCH_BITS = 16, 5 * 72


def misses(policy: CachePolicy, lines: int, keys: np.ndarray, **options) -> int:
    """Of one string, from an empty cache on."""
    cache = Cache(policy, lines=lines, **{"lfu_lines": lines, **options})
    cache.access(keys)
    return cache.misses


def ratios(string: np.ndarray) -> dict[CachePolicy, list[float]]:
    """Miss ratios under each policy, size by size."""
    return {policy: [misses(policy, lines, string) / max(1, len(string)) for lines in SIZES] for policy in NAMES}


def beginning(name: str, string: np.ndarray) -> str:
    """A row of miss ratios of the first requests for patches, which the tests replay in hardware."""
    first = string[:FIRST]
    cells = [f"{misses(policy, lines, first) / len(first):.3f}" for lines in FIRST_LINES for policy in NAMES]
    return f"| {name} | {' | '.join(cells)} |"


def cache_bits(lines: int) -> int:
    """Memory of a 4-way cache of patches: records with their errors, keys, and what a set knows of its ways."""
    memsys = CONFIG.memsys
    sets = lines // memsys.cache_ways
    key = KEY_BITS - (sets.bit_length() - 1)
    pairs = memsys.cache_ways * (memsys.cache_ways - 1) // 2
    return lines * (PATCH_BITS + 1 + key + 1) + sets * (memsys.cache_generation_bits + pairs)


def resident(name: str, strings: Strings) -> list[str]:
    """Table rows: share of a cluster's requests that its own memory or cache of as many bytes answers."""
    rows = []
    home = np.full(1 + max(int(string.max()) for frustum in strings.requests.patches for string in frustum
                           if len(string)), -1)
    for lines in OWN_LINES:
        capacity = cache_bits(lines) // PATCH_BITS
        frequency, own, near, cached, total = strings.plan.found.frequency, 0, 0, 0, 0
        home[:] = -1
        for cluster, held in enumerate(strings.plan.sets.patches):
            kept = held[np.argsort(-frequency[held], kind="stable")[:capacity]]
            home[kept[kept < len(home)]] = cluster
        for cluster in range(CLUSTERS):
            string = np.concatenate([frustum[cluster] for frustum in strings.requests.patches])
            own += int((home[string] == cluster).sum())
            near += int((home[string] >= 0).sum())
            cached += len(string) - misses(CachePolicy.LRU, lines, string)
            total += len(string)
        rows.append(f"| {name} | {lines} | {cache_bits(lines) // 8} | {capacity} | {own / total:.3f} "
                    f"| {near / total:.3f} | {cached / total:.3f} |")
    return rows


def write_chart_of(folder: Path, name: str, curves: dict[str, dict[CachePolicy, list[float]]]) -> None:
    """Miss ratios over the logarithm of the size."""
    lines = [Line(name=f"{what}: {NAMES[policy]}", x=np.log2(SIZES), y=np.array(values))
             for what, by_policy in curves.items() for policy, values in by_policy.items()]
    write_figure(folder / f"caches-{name}.svg", line_figure(
        lines, title=f"{name}: miss ratio", x_name="logarithm of the lines", y_name="miss ratio", y_top=1.0))


@click.command()
@click.argument("scenes", nargs=-1)
@output_option("caches")
def main(scenes: tuple[str, ...], output: Path) -> None:
    """Write tables and charts for SCENES (default: the five of the thesis)."""
    tables, sets, firsts = [], [], []
    for name in scenes or SCENES:
        strings = cast_strings(name, CONFIG, clusters=CLUSTERS, hemisphere=HEMISPHERE, cell=CELL)
        curves = {what: ratios(string) for what, string in strings.joined().items()}
        for what, string in strings.joined().items():
            for policy, values in curves[what].items():
                tables.append(f"| {name} | {what} | {len(string)} | {len(np.unique(string))} | {NAMES[policy]} | "
                              + " | ".join(f"{value:.3f}" for value in values) + " |")
        sets += resident(name, strings)
        firsts.append(beginning(name, strings.joined()["patches"]))
        write_chart_of(output.parent, name, curves)
        console().note("\n".join(tables[-2 * len(NAMES):]))
    lines = [
        "# Caches", "",
        f"{provenance('numpy')}; hemispheres of {len(HEMISPHERE)} rays from ceiling points "
        f"{', '.join(str(point) for point in POINTS)}, one after the other, {CLUSTERS} clusters whose requests take "
        f"turns, cell {CELL}.", "",
        "## Miss ratio against lines", "",
        "| scene | string | requests | different | placement | " + " | ".join(str(size) for size in SIZES) + " |",
        "|---" * (5 + len(SIZES)) + "|", *tables, "",
        f"## Miss ratio of the first {FIRST} requests for patches", "",
        "| scene | " + " | ".join(f"{lines}: {NAMES[policy]}" for lines in FIRST_LINES for policy in NAMES) + " |",
        "|---" * (1 + len(FIRST_LINES) * len(NAMES)) + "|", *firsts, "",
        "## Resident set and cache of equal bytes", "",
        "Share of the clusters' requests for patches that are answered: by the cluster's own resident set; by that of "
        "any cluster; by a 4-way LRU cache of the cluster's own, never emptied.", "",
        "| scene | lines | bytes | patches of the set | own set | any set | own cache |", "|---" * 7 + "|", *sets, ""]
    write_report(output, lines)
