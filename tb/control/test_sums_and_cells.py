# amaranth: UnusedElaboratable=no
"""The small parts: sums of clusters, cells of shell 1."""

import random

import numpy as np
import pytest
from amaranth.sim import Simulator

from golden.config import PRESETS
from golden.icu.collector import collect
from hw.control.near_cells import NearCells
from hw.control.sum_merge import SumMerge
from tb.lib.payload import pack, unpack
from tb.lib.timing import documented_latency

CONFIG = PRESETS["tiny"].replace({"ctu.near_cell_bits": 5})


def simulate(dut, sources, sinks, *, share, seed, before=None, cycles=5000):
    """What comes out of each sink, and when; sources and sinks wait in this share of the cycles."""
    draw, came = random.Random(seed), {name: [] for name in sinks}

    async def bench(ctx):
        if before is not None:
            await before(ctx)
        waiting, shown = {name: list(items) for name, (_, items) in sources.items()}, set()
        wanted = sum(count for _, count in sinks.values())
        for cycle in range(cycles):
            for name, (stream, _) in sources.items():
                if waiting[name] and (name in shown or draw.random() >= share):
                    shown.add(name)
                    ctx.set(stream.payload if isinstance(waiting[name][0], int) and not hasattr(
                        stream.payload, "as_value") else stream.payload.as_value(), waiting[name][0])
                ctx.set(stream.valid, name in shown)
            for stream, _ in sinks.values():
                ctx.set(stream.ready, draw.random() >= share)
            for name, (stream, _) in sources.items():
                if name in shown and ctx.get(stream.ready):
                    waiting[name].pop(0)
                    shown.discard(name)
            for name, (stream, _) in sinks.items():
                if ctx.get(stream.valid) and ctx.get(stream.ready):
                    came[name].append((cycle, unpack(stream.payload.shape(), ctx.get(stream.payload.as_value()))))
            await ctx.tick()
            if sum(map(len, came.values())) == wanted and not any(waiting.values()):
                break
        for _ in range(5):
            for stream, _ in sinks.values():
                assert not ctx.get(stream.valid), "more came than was asked for"
            await ctx.tick()

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    return came


@pytest.mark.parametrize("share", [0, 0.4])
@pytest.mark.parametrize("count", [1, 2, 3, 8])
def test_sums_are_those_of_all_hits(count, share):
    draw, patches = np.random.default_rng(count), 40
    hit, weights = draw.integers(-1, patches, 2000), draw.integers(0, 1 << 30, 2000)
    owner = draw.integers(0, count, 2000)
    dut = SumMerge(config=CONFIG, count=count)
    shape = dut.o.payload.shape()
    sources = {}
    for cluster in range(count):
        sums = collect(hit[owner == cluster], weights[owner == cluster], patches).tolist()
        sources[cluster] = dut.i[cluster], [
            pack(shape, {"patch": patch, "sum": value, "last": patch == patches - 1})
            for patch, value in enumerate(sums)]
    came = simulate(dut, sources, {"o": (dut.o, patches)}, share=share, seed=count)["o"]
    expected = collect(hit, weights, patches).tolist()
    assert [one for _, one in came] == [{"patch": patch, "sum": value, "overflow": 0,
                                         "last": int(patch == patches - 1)} for patch, value in enumerate(expected)]
    if not share:
        assert [cycle for cycle, _ in came] == list(range(dut.latency, dut.latency + patches)), "a sum per cycle"
    assert dut.latency == documented_latency(SumMerge, CONFIG, count=count)


@pytest.mark.parametrize("count", [2, 3, 8])
def test_sums_that_are_too_large_are_flagged(count):
    """A sum of all clusters that has no room, and one that had none in its cluster; not the largest that has room."""
    dut = SumMerge(config=CONFIG, count=count)
    shape = dut.o.payload.shape()
    largest = (1 << len(dut.o.payload.sum)) - 1
    given = [[(largest, 0), (largest, 0), (5, 1), (largest - 1, 0)]] + [
        [(0, 0), (int(k == count - 1), 0), (6, 0), (int(k == 1), 0)] for k in range(1, count)]
    sources = {k: (dut.i[k], [pack(shape, {"patch": patch, "sum": value, "overflow": overflow, "last": patch == 3})
                              for patch, (value, overflow) in enumerate(items)]) for k, items in enumerate(given)}
    came = simulate(dut, sources, {"o": (dut.o, 4)}, share=0, seed=count)["o"]
    assert [one["overflow"] for _, one in came] == [0, 1, 1, 0]
    assert [came[k][1]["sum"] for k in (0, 3)] == [largest, largest]


@pytest.mark.parametrize("count", [1, 2, 3, 8])
def test_a_sum_that_has_overflowed_in_any_cluster_is_flagged(count):
    """Patch k has overflowed in cluster k, the last patch in none."""
    dut = SumMerge(config=CONFIG, count=count)
    shape = dut.o.payload.shape()
    sources = {k: (dut.i[k], [pack(shape, {"patch": patch, "sum": 1, "overflow": int(patch == k),
                                           "last": patch == count}) for patch in range(count + 1)])
               for k in range(count)}
    came = simulate(dut, sources, {"o": (dut.o, count + 1)}, share=0, seed=count)["o"]
    assert [one["overflow"] for _, one in came] == [1] * count + [0]
    assert {one["sum"] for _, one in came} == {count}


@pytest.mark.parametrize(("count", "error"), [(0, ValueError), (-1, ValueError), (1.0, TypeError)])
def test_a_number_of_clusters_that_cannot_be(count, error):
    with pytest.raises(error, match="Count must be at least 1, not"):
        SumMerge(config=CONFIG, count=count)


@pytest.mark.parametrize("share", [0, 0.4])
@pytest.mark.parametrize("counts", [(5, 0, 1), (32, 2)])
def test_cells_of_shell_1_are_sent_for_every_frustum(counts, share):
    dut = NearCells(config=CONFIG)
    cells = [7 * k + 1 for k in range(32)]

    async def store(ctx):
        for address, cell in enumerate(cells):
            ctx.set(dut.i_load.payload, {"address": address, "cell": cell})
            ctx.set(dut.i_load.valid, 1)
            await ctx.tick()
        ctx.set(dut.i_load.valid, 0)

    expected = [(cells[k] if k < count else None, int(k < count), int(k == max(count, 1) - 1))
                for count in counts for k in range(max(count, 1))]
    came = simulate(dut, {"i": (dut.i, list(counts))}, {"o": (dut.o, len(expected))}, share=share, seed=1,
                    before=store)["o"]
    assert [(one["cell"] if one["is_cell"] else None, one["is_cell"], one["last"]) for _, one in came] == expected
    if not share:
        assert came[0][0] == dut.latency == documented_latency(NearCells, CONFIG)
        assert [cycle - came[0][0] for cycle, _ in came[:max(counts[0], 1)]] == list(range(max(counts[0], 1)))
