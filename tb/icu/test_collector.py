from itertools import pairwise

import cocotb
import numpy as np
import pytest
from cocotb.triggers import ClockCycles, RisingEdge

from golden.frustum import Hemisphere
from golden.icu.collector import collect
from golden.stimulus import block
from golden.stimulus.frusta import HEMISPHERE
from hw.icu.collector import Collector
from hw.icu.icu_formats import WEIGHT_BITS, IcuFormats, TableKind
from tb.lib.clocking import reset, start
from tb.lib.configurations import config_of
from tb.lib.no_x import assert_known
from tb.lib.ports import Ports
from tb.lib.runner import SIMULATORS, options, simulate
from tb.lib.stall_patterns import STALL_PAIRS
from tb.lib.timing import documented_latency

SMALL = {"icu.side_bits": 6, "icu.patch_bits": 8}
CONFIG = config_of(SMALL)
CONFIG_FORMATS = IcuFormats(CONFIG)
PATCHES = 1 << CONFIG.icu.patch_bits
SIDE = 1 << CONFIG.icu.side_bits
COLUMNS, ROWS = HEMISPHERE
# As many as there are, of a hemisphere of that many rows; the others are large.
WEIGHTS = np.resize(Hemisphere(*HEMISPHERE).polar_weights, SIDE)
WEIGHTS[ROWS:] = (1 << WEIGHT_BITS) - 1 - np.arange(SIDE - ROWS)


def items(patch, row):
    """Rays that hit a patch, or none: -1."""
    hits = ({"inverse": 1 + int(hit), "patch": int(hit)} if hit >= 0 else {} for hit in patch)
    return [{"row": int(row), "hit": hit} for hit, row in zip(hits, row, strict=True)]


def expected(patch, row):
    """Sums of all patches."""
    return collect(np.asarray(patch), WEIGHTS[np.asarray(row, dtype=int)], PATCHES)


def hemisphere_rays(seed, count=400):
    """Golden's stimulus, and the rays' rows."""
    patch = block("icu.collector")[1].draw(np.random.default_rng(seed), count, CONFIG)["patch"]
    row = np.resize(np.repeat(np.arange(ROWS), COLUMNS), count)
    return patch, row


class Bench:
    """The streams of a collector whose weights have been written."""

    def __init__(self, dut, *, hits="none", sums="none"):
        self.ports = Ports(dut, Collector(config=CONFIG), stalls={"i": hits, "o": sums})
        self.dut, self.sum = dut, self.ports.sinks["o"]

    async def write_weights(self):
        """All rows, among writes of other tables to the same rows."""
        await self.ports.send("i_table", [
            {"kind": kind.value, "index": row, "data": data} for row, weight in enumerate(WEIGHTS.tolist())
            for kind, data in ((TableKind.WEIGHT, weight), (TableKind.SLACK, 3), (TableKind.ROW, 5))])

    async def sums(self, count=PATCHES):
        """The sums of the first patches, none of which has overflowed."""
        found = await self.entries(count)
        assert not any(entry["overflow"] for entry in found)
        return np.array([entry["sum"] for entry in found], dtype=np.int64)

    async def entries(self, count=PATCHES):
        """What comes out for the first patches."""
        before = len(self.sum.items)
        await self.ports.send("i_read", [count])
        await self.ports.until(lambda: len(self.sum.items) >= before + count)
        await ClockCycles(self.dut.clk, 12)
        found = self.ports.came("o", before)
        assert [entry["patch"] for entry in found] == list(range(count))
        assert [entry["last"] for entry in found] == [0] * (count - 1) + [1] * (count > 0)
        return found


@cocotb.test()
async def every_pair_of_stalls(dut):
    """Sums are golden's, and begin at 0 again when they have been read."""
    await start(dut, cycles=200_000)
    bench = Bench(dut)
    await RisingEdge(dut.clk)
    assert_known(dut, [*bench.ports.sources, *bench.ports.sinks])
    await bench.write_weights()
    for number, (hits, sums) in enumerate(STALL_PAIRS):
        bench.ports.stop()
        bench = Bench(dut, hits=hits, sums=sums)
        patch, row = hemisphere_rays(number + options()["seed"])
        await bench.ports.send("i", items(patch, row))
        assert (await bench.sums() == expected(patch, row)).all()
    assert not (await bench.sums()).any()


@cocotb.test()
async def the_same_patch_after_every_number_of_cycles(dut):
    """Hits of one patch in consecutive cycles, of two by turns, and so on; the sums keep every weight."""
    await start(dut, cycles=20_000)
    bench = Bench(dut)
    await bench.write_weights()
    random = np.random.default_rng(options()["seed"])
    for ahead in range(1, 9):
        patch, row = np.arange(96) % ahead, random.integers(0, SIDE, 96)
        # Rays without a hit keep the others' distance.
        patch[random.random(96) < 0.2] = -1
        # Fewer of the large weights than a sum can hold.
        row[3::4] %= ROWS
        row[np.cumsum(row >= ROWS) > 3] %= ROWS
        await bench.ports.send("i", items(patch, row))
        assert (await bench.sums(9) == expected(patch, row)[:9]).all()


@cocotb.test()
async def an_overflowing_sum_is_flagged(dut):
    """Until it is read; the sums beside it are not, and what follows begins anew."""
    await start(dut, cycles=20_000)
    bench = Bench(dut)
    await bench.write_weights()
    limit = 1 << CONFIG_FORMATS.weight_sum.width
    patch, row = [1, 2, 1, 1, 1, 2, 2, 1, 1, 1], [ROWS] * 10
    sums = expected(patch, row)
    assert sums[1] >= limit > sums[2]
    await bench.ports.send("i", items(patch, row))
    found = await bench.entries(4)
    assert [entry["overflow"] for entry in found] == [0, 1, 0, 0]
    assert found[2]["sum"] == sums[2]
    await bench.ports.send("i", items(patch[:2], row[:2]))
    assert (await bench.sums(4) == expected(patch[:2], row[:2])[:4]).all()


@cocotb.test()
async def sums_are_requested_while_hits_come(dut):
    """Wherever a read falls, each weight is in the sums of one read; what is not read stays."""
    await start(dut, cycles=100_000)
    bench = Bench(dut, hits="bursts", sums="random")
    await bench.write_weights()
    patch, row = hemisphere_rays(options()["seed"], 1500)
    hits = bench.ports.begin("i", items(patch, row))
    found = np.zeros(PATCHES, dtype=np.int64)
    for count in (1, 7, 0, 64, 33, 0, PATCHES, 2):
        found[:count] += await bench.sums(count)
        await ClockCycles(dut.clk, 41)
    assert not hits.done(), "hits must come to the end of the reads"
    await hits
    found += await bench.sums()
    assert (found == expected(patch, row)).all()


@cocotb.test()
async def reset_in_flight(dut):
    """All sums are 0 after a reset, whether hits were coming, sums were leaving, or they were being cleared."""
    await start(dut, cycles=60_000)
    patch, row = hemisphere_rays(3)
    for number, cut in enumerate((2, 5, 90, 300)):
        bench = Bench(dut, sums="alternating")
        await bench.write_weights()
        await bench.ports.send("i", items(patch, row))
        if number % 2:
            bench.ports.begin("i", items(patch, row))
        else:
            bench.ports.begin("i_read", [PATCHES])
        await ClockCycles(dut.clk, cut)
        await bench.ports.reset()
        bench.ports.stop()
        # The clearing has to begin anew too.
        await ClockCycles(dut.clk, 20)
        await reset(dut)
        bench = Bench(dut)
        assert not (await bench.sums()).any()
        await bench.ports.send("i", items(patch, row))
        assert (await bench.sums() == expected(patch, row)).all()
        bench.ports.stop()


@cocotb.test()
async def one_per_cycle(dut):
    """Hits and sums go one per cycle, and the first sum comes after the latency that the docstring states."""
    await start(dut, cycles=10_000)
    bench = Bench(dut)
    await bench.write_weights()
    await bench.ports.until(lambda: not bench.ports["busy"])
    taken, reads = bench.ports.taken("i"), bench.ports.taken("i_read")
    patch, row = hemisphere_rays(4)
    await bench.ports.send("i", items(patch, row))
    await ClockCycles(dut.clk, 10)
    await bench.sums()
    assert {b - a for a, b in pairwise(taken.cycles)} == {1}, "hits must be taken without a gap"
    assert {b - a for a, b in pairwise(bench.sum.cycles)} == {1}, "sums must come without a gap"
    assert bench.sum.cycles[0] - reads.cycles[0] == documented_latency(Collector, CONFIG)


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    simulate(Collector(config=CONFIG), __name__, simulator=simulator)
