"""The small parts: sums of clusters, cells of shell 1."""

import random

import numpy as np
import pytest

from golden.config import PRESETS
from golden.icu.collector import collect
from hw.control.near_cells import NearCells
from hw.control.sum_merge import SumMerge
from hw.icu.icu_formats import WEIGHT_SUM_BITS
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.timing import documented_latency

CONFIG = PRESETS["tiny"].replace({"ctu.near_cell_bits": 5})


def run(dut, items, *, most=0, first=None):
    """What comes out, and the cycles of all transfers; sources and sinks wait up to ``most`` cycles."""
    draw = random.Random(1)

    def waits():
        return draw.choice((0, 0, draw.randrange(most + 1)))

    bench = ScheduleBench(dut)
    came = bench.run(Schedule(items={name: [(waits(), item) for item in some] for name, some in items.items()},
                              stalls={"o": [waits() for _ in range(99)]}, first=first or {}))
    return came["o"], bench.cycles


def merged(given, **stalls):
    """The sums of clusters that have these sums and overflows of each patch."""
    dut = SumMerge(config=CONFIG, count=len(given))
    return run(dut, {f"i__{cluster}": [
        {"patch": patch, "sum": value, "overflow": overflow, "last": patch == len(sums) - 1}
        for patch, (value, overflow) in enumerate(sums)] for cluster, sums in enumerate(given)}, **stalls)


@pytest.mark.parametrize("most", [0, 4])
@pytest.mark.parametrize("count", [1, 2, 3, 8])
def test_sums_are_those_of_all_hits(count, most):
    draw, patches = np.random.default_rng(count), 40
    hit, weights = draw.integers(-1, patches, 2000), draw.integers(0, 1 << 30, 2000)
    owner = draw.integers(0, count, 2000)
    came, cycles = merged([[(value, 0) for value in collect(
        hit[owner == cluster], weights[owner == cluster], patches).tolist()] for cluster in range(count)], most=most)
    assert came == [{"patch": patch, "sum": value, "overflow": 0, "last": int(patch == patches - 1)}
                    for patch, value in enumerate(collect(hit, weights, patches).tolist())]
    latency = documented_latency(SumMerge, CONFIG, count=count)
    assert SumMerge(config=CONFIG, count=count).latency == latency
    if not most:
        assert cycles["o"] == [cycle + latency for cycle in cycles["i__0"]]
        assert cycles["o"] == list(range(1 + latency, 1 + latency + patches)), "a sum per cycle"


@pytest.mark.parametrize("count", [2, 3, 8])
def test_sums_that_are_too_large_are_flagged(count):
    """A sum of all clusters that overflows, and one that overflowed in its cluster; not the largest that fits."""
    largest = (1 << WEIGHT_SUM_BITS) - 1
    came, _ = merged([[(largest, 0), (largest, 0), (5, 1), (largest - 1, 0)]] + [
        [(0, 0), (int(k == count - 1), 0), (6, 0), (int(k == 1), 0)] for k in range(1, count)])
    assert [one["overflow"] for one in came] == [0, 1, 1, 0]
    assert [came[k]["sum"] for k in (0, 3)] == [largest, largest]


@pytest.mark.parametrize("count", [1, 2, 3, 8])
def test_a_sum_that_has_overflowed_in_any_cluster_is_flagged(count):
    """Patch k has overflowed in cluster k, the last patch in none."""
    came, _ = merged([[(1, int(patch == k)) for patch in range(count + 1)] for k in range(count)])
    assert [one["overflow"] for one in came] == [1] * count + [0]
    assert {one["sum"] for one in came} == {count}


@pytest.mark.parametrize(("count", "error"), [(0, ValueError), (-1, ValueError), (1.0, TypeError)])
def test_a_number_of_clusters_that_cannot_be(count, error):
    with pytest.raises(error, match="Count must be at least 1, not"):
        SumMerge(config=CONFIG, count=count)


@pytest.mark.parametrize("most", [0, 4])
@pytest.mark.parametrize("counts", [(5, 0, 1), (32, 2)])
def test_cells_of_shell_1_are_sent_for_every_frustum(counts, most):
    cells = [7 * k + 1 for k in range(32)]
    dut = NearCells(config=CONFIG)
    came, cycles = run(dut, {"i": counts}, most=most, first={
        "i_load": [{"address": address, "cell": cell} for address, cell in enumerate(cells)]})
    assert [(one["cell"] if one["is_cell"] else None, one["is_cell"], one["last"]) for one in came] == [
        (cells[k] if k < count else None, int(k < count), int(k == max(count, 1) - 1))
        for count in counts for k in range(max(count, 1))]
    if not most:
        begin = cycles["i"][0] + dut.latency
        assert dut.latency == documented_latency(NearCells, CONFIG)
        assert cycles["o"][:counts[0]] == list(range(begin, begin + counts[0]))
