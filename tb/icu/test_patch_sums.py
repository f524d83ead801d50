"""Sums of sections; those of `golden.engine.jobs` predict every item."""

from collections import Counter
from contextlib import nullcontext
from itertools import pairwise

import cocotb
import numpy as np
import pytest
from cocotb.triggers import ClockCycles, RisingEdge
from cocotb.utils import get_sim_time
from hypothesis import given, settings
from hypothesis import strategies as st

from golden.cast.hemisphere import Hemisphere
from golden.engine.icu.patch_sums import SUM_BITS, section_sums
from golden.engine.stimulus.frusta import HEMISPHERE
from hw.icu import patch_sums
from hw.icu.icu_formats import WEIGHT_BITS, TableKind
from hw.icu.patch_sums import PatchSums
from hw.lib.checks import checked
from tb.lib.clocking import PERIOD, reset, start
from tb.lib.configurations import config_of
from tb.lib.no_x import assert_known
from tb.lib.ports import Ports
from tb.lib.runner import SIMULATORS, options, simulate
from tb.lib.schedules import SETTINGS, Schedule, ScheduleBench, schedules
from tb.lib.scoreboard import check
from tb.lib.stall_patterns import stall_pairs
from tb.lib.timing import documented_latency

SMALL = {"icu.side_bits": 6, "icu.patch_bits": 8, "icu.rays": 64}
CONFIG = config_of(SMALL)
SHAPE = PatchSums(config=CONFIG).o.payload.shape()
PATCHES, MOST = 1 << CONFIG.icu.patch_bits, CONFIG.icu.rays
SIDE = 1 << CONFIG.icu.side_bits
# Cycles in which a read of all sums ends.
LATER = MOST + 20
ROWS = HEMISPHERE[1]
# Those of a hemisphere, then a row without weight, and large ones.
WEIGHTS = np.resize(Hemisphere(*HEMISPHERE).polar_weights, SIDE)
WEIGHTS[ROWS] = 0
WEIGHTS[ROWS + 1:] = (1 << WEIGHT_BITS) - 1 - np.arange(SIDE - ROWS - 1)
TABLE = [{"kind": kind.value, "index": row, "data": data} for row, weight in enumerate(WEIGHTS.tolist())
         for kind, data in ((TableKind.WEIGHT, weight), (TableKind.SLACK, 3), (TableKind.ROW, 5))]
NOTHING = {"patch": None, "sum": None, "overflow": None, "is_sum": 0, "last": 1}


def items(patch, row):
    """Rays that hit a patch, or none: -1."""
    hits = ({"inverse": 1 + int(hit), "patch": int(hit)} if hit >= 0 else {} for hit in patch)
    return [{"row": int(row), "hit": hit} for hit, row in zip(hits, row, strict=True)]


def expected(patch, row):
    """What a read after these hits gives."""
    golden = section_sums(np.asarray(patch, dtype=np.int64), WEIGHTS[np.asarray(row, dtype=int)])
    found = [{"patch": one, "sum": value % (1 << SUM_BITS) if value >> SUM_BITS == 0 else None,
              "overflow": int(value >> SUM_BITS > 0), "is_sum": 1, "last": 0}
             for one, value in zip(golden.patch.tolist(), golden.sum.tolist(), strict=True)]
    over = [item["patch"] for item in found if item["overflow"]]
    assert golden.overflow == (over[0] if over else -1)
    return [*found[:-1], {**found[-1], "last": 1}] if found else [NOTHING]


def section(seed, count=MOST):
    """Row by row, some rows without weight; many rays hit one patch, and some none."""
    draw = np.random.default_rng(seed)
    patch = np.where(draw.random(count) < 0.4, draw.integers(PATCHES), draw.integers(0, PATCHES, count))
    return np.where(draw.random(count) < 0.2, -1, patch), np.sort(draw.integers(0, ROWS + 1, count))


class SumsBench:
    """The streams, with a table of weights, and what must have come."""

    def __init__(self, dut, *, hits="none", sums="none"):
        self.ports = Ports(dut, PatchSums(config=CONFIG), stalls={"i": hits, "o": sums})
        self.dut, self.expected = dut, []
        dut.patches.value = PATCHES

    async def cast(self, patch, row):
        """The hits of a section and its read."""
        self.expected += expected(patch, row)
        await self.ports.send("i", items(patch, row))
        await self.ports.send("i_read", [0])

    async def compare(self):
        """All that was cast has come and nothing else."""
        came = self.ports.sinks["o"].items
        await self.ports.until(lambda: len(came) >= len(self.expected))
        await ClockCycles(self.dut.clk, 20)
        check(SHAPE, came, self.expected, what="o")
        self.ports.stop()


@cocotb.test()
async def every_pair_of_stalls(dut):
    """Sections one after the other, some of them without a sum."""
    await start(dut, cycles=100_000)
    bench = SumsBench(dut)
    await RisingEdge(dut.clk)
    assert_known(dut, [*bench.ports.sources, *bench.ports.sinks])
    await bench.ports.send("i_table", TABLE)
    for number, (hits, sums) in enumerate(stall_pairs()):
        bench.ports.stop()
        bench = SumsBench(dut, hits=hits, sums=sums)
        for count in (MOST, 0, 9, MOST):
            await bench.cast(*section(7 * number + count + options()["seed"], count))
        await bench.cast([3, -1, 4], [ROWS, 0, ROWS])
        await bench.cast([3, -1, 5], [ROWS, 0, 1])
        await bench.compare()


@cocotb.test()
async def the_same_patch_after_every_number_of_cycles(dut):
    """Hits of one patch in consecutive cycles, of two by turns, and so on; each patch is listed once."""
    await start(dut, cycles=20_000)
    bench = SumsBench(dut)
    await bench.ports.send("i_table", TABLE)
    random = np.random.default_rng(options()["seed"])
    for ahead in range(1, 9):
        for first in (ROWS, 0):
            patch, row = np.arange(MOST) % ahead, random.integers(0, ROWS + 1, MOST)
            # Rays without a hit keep the others' distance.
            patch[random.random(MOST) < 0.2] = -1
            # The first hits may have no weight: then their patches are listed later.
            row[:ahead + 1] = first
            await bench.cast(patch, row)
    await bench.compare()


@cocotb.test()
async def a_sum_that_overflows_is_flagged(dut):
    """Also if the last weight makes no carry; those beside it are not, and the next section begins at 0."""
    await start(dut, cycles=20_000)
    bench = SumsBench(dut)
    await bench.ports.send("i_table", TABLE)
    large, small = ROWS + 1, 0
    for patch, row in (([1, 2, 1, 3, 1, 1], [large] * 6), ([1, 2, 3], [large] * 3),
                       ([9, 9, 8, 9], [large, small, large, small]), ([9, 8], [small] * 2)):
        await bench.cast(patch, row)
    assert Counter(item["overflow"] for item in bench.expected)[1] == 2
    await bench.compare()


@cocotb.test()
async def resets_in_flight(dut):
    """All sums and the list are empty after a reset, whether hits were coming, sums were leaving, or being cleared."""
    await start(dut, cycles=60_000)
    for number, cut in enumerate((2, 5, 30, 90)):
        bench = SumsBench(dut, sums="alternating")
        await bench.ports.send("i_table", TABLE)
        patch, row = section(number)
        await bench.ports.send("i", items(patch, row))
        if number % 2:
            await bench.ports.send("i_read", [0])
        bench.ports.begin("i", items(patch, row))
        await ClockCycles(dut.clk, cut)
        await bench.ports.reset()
        bench.ports.stop()
        # The clearing has to begin anew too.
        await ClockCycles(dut.clk, 20)
        await reset(dut)
        bench = SumsBench(dut)
        for seed in (number, number + 9):
            await bench.cast(*section(seed))
        await bench.compare()


@cocotb.test()
async def sums_are_cleared_as_far_as_the_scene_needs(dut):
    """After a reset hits wait one cycle for each patch of the scene; those of a larger scene, for the further ones."""
    await start(dut, cycles=20_000)
    bench = SumsBench(dut)
    await bench.ports.send("i_table", TABLE)
    for first in range(0, PATCHES, MOST):
        await bench.ports.send("i", items(range(first, first + MOST), [0] * MOST))
    few = 7
    bench.ports.stop()
    dut.rst.value = 1
    await ClockCycles(dut.clk, 2)
    bench = SumsBench(dut)
    dut.patches.value = few
    taken, cleared, waited = bench.ports.taken("i"), [0], []
    dut.rst.value = 0
    for patches in (few, PATCHES - 2, PATCHES - 2, PATCHES):
        # A larger scene comes with a load: long after the last read, and before the next hits.
        await ClockCycles(dut.clk, LATER)
        dut.patches.value = patches
        await ClockCycles(dut.clk, LATER)
        before, offered = len(taken.cycles), round(get_sim_time("ns") / PERIOD)
        patch = range(max(0, patches - MOST), patches)
        await bench.cast(patch, [0] * len(patch))
        waited.append(taken.cycles[before] - offered)
        cleared.append(patches)
    for more, cycles in zip(np.diff(cleared), waited, strict=True):
        assert more - LATER - 5 <= cycles <= max(1, more - LATER + 5), f"hits wait for {more} sums, not {cycles} cycles"
    await bench.compare()


@cocotb.test()
async def one_per_cycle(dut):
    """Hits and sums go one per cycle; reads, sums and the next section's hits come when the docstring says so."""
    await start(dut, cycles=10_000)
    bench = SumsBench(dut)
    await bench.ports.send("i_table", TABLE)
    await bench.cast([-1], [0])
    came = bench.ports.sinks["o"]
    taken, read_in = bench.ports.taken("i"), bench.ports.taken("i_read")
    (patch, row), (next_patch, next_row) = section(4), section(5)
    await bench.ports.send("i", items(patch, row))
    following = bench.ports.begin("i_read", [0])
    await RisingEdge(dut.clk)
    bench.expected += expected(patch, row)
    await bench.ports.send("i", items(next_patch, next_row))
    await following
    await bench.ports.send("i_read", [0])
    bench.expected += expected(next_patch, next_row)
    await bench.ports.until(lambda: len(came.items) >= len(bench.expected))
    sums = len(expected(patch, row))
    parts = taken.cycles[:MOST], taken.cycles[MOST:], came.cycles[1:1 + sums], came.cycles[1 + sums:]
    assert {b - a for part in parts for a, b in pairwise(part)} == {1}, "hits and sums must go one per cycle"
    assert read_in.cycles[0] - taken.cycles[MOST - 1] == 8, "a read must be accepted 8 cycles after the last hit"
    assert came.cycles[1] - read_in.cycles[0] == documented_latency(PatchSums, CONFIG)
    assert taken.cycles[MOST] - read_in.cycles[0] == sums + 1, "hits must stall while the list is read, and no longer"
    await bench.compare()


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    simulate(PatchSums(config=CONFIG), __name__, simulator=simulator)


BENCH = ScheduleBench(PatchSums(config=CONFIG), idle_limit=PATCHES + 40)
# Rows of all kinds of weights.
SOME = 0, 1, ROWS, ROWS + 1
HITS = st.builds(lambda patch, row: items([patch], [row])[0], st.sampled_from((-1, 0, 0, 1, 1, 2, 200)),
                 st.sampled_from(SOME))


@settings(SETTINGS, max_examples=10)
@given(schedules({"i": HITS, "i_read": st.just(0)}, ["o"]))
def test_reads_at_any_time(schedule):
    """A hit is in the sums of the first read that is accepted after it."""
    BENCH.run(type(schedule)(items={**schedule.items, "i_table": []}, stalls=schedule.stalls,
                             first={"i_table": [one for one in TABLE if one["index"] in SOME]}))
    hits, entered, reads = schedule.values("i"), BENCH.cycles["i"], BENCH.cycles["i_read"]
    required = []
    for before, read in pairwise([0, *reads]):
        those = [hit for hit, cycle in zip(hits, entered, strict=True) if before < cycle <= read]
        required += expected([hit["hit"].get("patch", -1) if hit["hit"] else -1 for hit in those],
                           [hit["row"] for hit in those])
    check(SHAPE, BENCH.came["o"], required, what="o")


@pytest.mark.parametrize("fewer", [0, 1])
def test_a_read_that_does_not_wait_for_the_last_hit_is_found(monkeypatch, fewer):
    """With one cycle less the hit enters the list while it is read: the claim ends the simulation."""
    monkeypatch.setattr(patch_sums, "SETTLED", patch_sums.SETTLED - fewer)
    bench = ScheduleBench(PatchSums(config=CONFIG), idle_limit=PATCHES + 40)
    first, last = items([1, 2], [1, 1])
    schedule = Schedule(items={"i_table": [], "i": [(12, first), (0, last)], "i_read": [(13, 0)]},
                        first={"i_table": TABLE})
    outcome = pytest.raises(AssertionError, match="a hit is in the list before it is read") if fewer else nullcontext()
    with checked(), outcome:
        bench.run(schedule, patches=4)
