"""The paper's machine: patches pushed against patches pulled, its hierarchy of memories, and its other figures.

``radiosity bench paper_machine`` simulates a refinement step on 1 to 1024 clusters and writes
out/bench/paper_machine.md with a chart for each scene. It grades the paper's figures: 15 % by the hierarchy, the
effectiveness of low-density castings, and caches with LFU against direct ones. Nothing is set for a scene.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from benchmarks.ceiling import Ceiling
from benchmarks.grades import grade_of, signed
from benchmarks.report import benchmark, provenance, table, write_chart, write_report
from golden.cast.hemisphere import Hemisphere
from golden.engine.config import PRESETS, Config
from golden.engine.memsys.bus.cache import Cache
from golden.engine.memsys.bus.cache_policy import CachePolicy
from golden.engine.schedule.usage import cumulative_frequency, effectiveness, usage_order
from radiosity.charts.chart import Line
from radiosity.cli.console import console
from radiosity.machines.paper.paper_machine import PaperMachine, PaperRun, PaperSpec
from radiosity.machines.paper.ray_string import ray_string
from radiosity.machines.paper.supply import Supply

__all__ = ["grade_effectiveness", "grade_gain", "grade_misses", "nearest_power"]

_SCENES = ("lobby", "room1627")
# Clusters, and points along each side of the patch that cast the hemispheres of a step.
_NODES, _SAMPLES = (1, 2, 4, 8, 16, 64, 256, 1024), 2
_CONFIG = PRESETS["paper"].replace({"memsys.own_patches": 4096})
_CELL, _RAYS, _POINT = 0.0625, (256, 64), 5
# Clusters for which the paper's gain is graded: no figure of the paper has more.
_GRADED = 16
# A gain that is the paper's 15 %, and its effectiveness.
_GAIN, _EFFECTIVENESS = (0.05, 0.30), (0.7, 0.8)
# Lines of caches; bits of a use count that never saturates.
_LINES, _COUNT_BITS = (8, 16, 32, 64, 128, 256, 512), 20
# Rays for each one of a low-density casting, beside twice the degree of coherence.
_RATIOS = (16, 512)


def grade_gain(gain: float) -> str:
    """What has become of the paper's 15 % by the hierarchy: from 5 to 30 %; a gain at all, above 1 %; or none."""
    return grade_of(_GAIN[0] <= gain <= _GAIN[1], gain > 0.01)


def grade_effectiveness(value: float, *, sparser: float, denser: float) -> str:
    """What has become of 0.7 to 0.8: a value there; or one that falls with fewer rays; or neither."""
    return grade_of(_EFFECTIVENESS[0] <= value <= _EFFECTIVENESS[1], sparser < value < denser)


def grade_misses(direct: Sequence[float], lfu: Sequence[float]) -> str:
    """What has become of LFU that misses less: at all sizes; at most of those that differ; or not."""
    fewer, more = sum(np.less(lfu, direct)), sum(np.greater(lfu, direct))
    return grade_of(fewer > 0 == more, fewer > more)


def nearest_power(value: float) -> int:
    """The power of two nearest to a value, by their ratio."""
    return 1 << max(0, round(np.log2(value)))


class _Strings:
    """Strings of references of castings from a point of a scene's ceiling."""

    def __init__(self, scene: str, config: Config):
        self._ceiling = Ceiling(scene, config, point=_POINT)
        self._config, self._patches = config, len(self._ceiling.scene)
        self.dense, hits = self._cast(1)
        hit = hits.patch[hits.patch >= 0]
        self.coherence = len(hit) / len(np.unique(hit))

    def _cast(self, ratio):
        bits = ratio.bit_length() - 1
        record = self._ceiling.record(hemisphere=Hemisphere(_RAYS[0] >> (bits + 1) // 2, _RAYS[1] >> bits // 2))
        hits, _ = self._ceiling.shelling.cast(record)
        return ray_string(record, hits, self._ceiling.shelling.table, self._config), hits

    def _frequency(self, string):
        return np.bincount(string, minlength=self._patches)

    def effectiveness(self, ratio: int) -> tuple[np.ndarray, float]:
        """E(k) of a casting with one of ``ratio`` rays, and the share of all references that its patches serve."""
        dense, sparse = self._frequency(self.dense), self._frequency(self._cast(ratio)[0])
        order = usage_order(sparse)[:np.count_nonzero(sparse)]
        return effectiveness(dense, sparse), cumulative_frequency(dense, order)

    def misses(self, policy: CachePolicy) -> list[float]:
        """Miss ratios by size."""
        found = []
        for lines in _LINES:
            cache = Cache(policy, lines=lines, lfu_lines=lines, lfu_count_bits=_COUNT_BITS)
            cache.access(self.dense)
            found.append(cache.misses / max(1, len(self.dense)))
        return found


def _runs(scene: str, nodes: Sequence[int], samples: int) -> Iterator[dict[Supply, PaperRun]]:
    """The runs of each size with each supply."""
    for count in nodes:
        machine = PaperMachine(PaperSpec(scene=scene, samples=samples, rays=_RAYS, cell=_CELL), _CONFIG, nodes=count)
        found = {supply: machine.run(supply) for supply in Supply}
        console().note(f"{scene}, {count} clusters: {[run.cycles for run in found.values()]} cycles")
        yield found


def _supply_rows(scene: str, runs: list[dict[Supply, PaperRun]]) -> list[list]:
    rows = []
    for run in runs:
        pushed, pulled = run[Supply.PUSHED], run[Supply.PULLED]
        traffic = [one.report()["traffic"] for one in (pushed, pulled)]
        memory = pushed.report()["memory"]
        rows.append([f"`{scene}`", f"{pushed.nodes}{' *' if pushed.is_extrapolated else ''}", f"{pushed.cycles:,}",
                     f"{pulled.cycles:,}", f"{pulled.cycles / pushed.cycles:.2f}",
                     *(f"{one.efficiency:.3f}" for one in (pushed, pulled)),
                     *(f"{one['root_share']:.2f}" for one in traffic), *(f"{one['link_words']:,}" for one in traffic),
                     memory["most_held"], memory["most_deferred"]])
    return rows


def _gain_rows(scene: str, runs: list[dict[Supply, PaperRun]]) -> list[list]:
    rows = []
    for run in runs:
        main, pushed = run[Supply.MAIN], run[Supply.PUSHED]
        if pushed.nodes <= _GRADED:
            gain = main.cycles / pushed.cycles - 1
            rows.append([f"`{scene}`", pushed.spec.samples**2, pushed.nodes, f"{main.cycles:,}", f"{pushed.cycles:,}",
                         signed(gain), grade_gain(gain)])
    return rows


def _chart(scene: str, runs: list[dict[Supply, PaperRun]]) -> None:
    lines = []
    for supply in (Supply.PUSHED, Supply.PULLED):
        chosen = [run[supply] for run in runs]
        rates = [sum(len(frustum.record) for step in one.steps for frustum in step.prepared.frusta) / one.cycles
                 for one in chosen]
        lines.append(Line(name=supply.value, x=np.log2([one.nodes for one in chosen]), y=np.array(rates)))
    write_chart(
        f"paper-{scene}", lines, title=f"{scene}: one hemisphere of {_RAYS[0]} x {_RAYS[1]} rays",
        x_name="logarithm of the clusters (extrapolated above 4)", y_name="rays per cycle",
        y_top=1.1 * max(float(line.y.max()) for line in lines))


def _string_rows(scene: str) -> tuple[list[list], list[list]]:
    """Rows of the effectiveness, and of miss ratios."""
    strings = _Strings(scene, _CONFIG)
    advised = nearest_power(2 * strings.coherence)
    found = {ratio: strings.effectiveness(ratio) for ratio in sorted({advised, *_RATIOS})}
    means = {ratio: float(curve.mean()) for ratio, (curve, _) in found.items()}
    effective = [[f"`{scene}`", f"{strings.coherence:.1f}", ratio, len(curve), f"{curve.min():.3f}",
                  f"{means[ratio]:.3f}", f"{curve[-1]:.3f}", f"{share:.3f}",
                  grade_effectiveness(means[ratio], sparser=means[max(found)], denser=means[min(found)])
                  if ratio == advised else ""] for ratio, (curve, share) in found.items()]
    direct, lfu = (strings.misses(policy) for policy in (CachePolicy.DIRECT, CachePolicy.LFU))
    console().note(f"{scene}: strings of {len(strings.dense)} references")
    return effective, [[f"`{scene}`", name, *(f"{ratio:.3f}" for ratio in ratios), text] for name, ratios, text in (
        ("direct", direct, ""), ("fully associative, LFU", lfu, grade_misses(direct, lfu)))]


@benchmark("paper_machine", _SCENES)
def main(scenes) -> None:
    """Simulate the paper's machine; SCENES default to lobby and room1627."""
    supply, gain, effective, misses = [], [], [], []
    for scene in scenes:
        strings = _string_rows(scene)
        effective += strings[0]
        misses += strings[1]
        runs = list(_runs(scene, _NODES, 1))
        supply += _supply_rows(scene, runs)
        graded = [count for count in _NODES if count <= _GRADED]
        gain += _gain_rows(scene, [*runs, *_runs(scene, graded, _SAMPLES)])
        _chart(scene, runs)
    write_report(
        "The paper's machine, simulated",
        f"{provenance('numpy')}; preset paper, a step of hemispheres of {_RAYS[0]} x {_RAYS[1]} rays on the patch with "
        f"most light, cell {_CELL:g}, one ray of 64 at low density, two traversal units for each cluster, main memory "
        "10 cycles away. * extrapolated: hardware of so many clusters has not been simulated.",
        "One hemisphere:",
        table(["scene", "clusters", "cycles, pushed", "cycles, pulled", "pulled : pushed", "efficiency, pushed",
               "efficiency, pulled", "root link, pushed", "root link, pulled", "words on links, pushed",
               "words on links, pulled", "resident patches", "deferred rays"], supply),
        "The hierarchy against main memory alone (the paper: 15 %):",
        table(["scene", "hemispheres", "clusters", "main memory", "hierarchy", "gain", "grade"], gain),
        f"Strings of references by ray, from point {_POINT} of the ceiling. Effectiveness at twice the degree of "
        "coherence (the paper: 0.7 to 0.8):",
        table(["scene", "ADRC", "ratio", "patches found", "least E(k)", "mean E(k)", "last E(k)", "share served",
               "grade"], effective),
        "Miss ratios by lines (the paper: LFU is better):",
        table(["scene", "placement", *_LINES, "grade"], misses))
