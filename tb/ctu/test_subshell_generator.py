# amaranth: UnusedElaboratable=no

"""A list as it is in the table, then the last subshell; what cannot be right ends it with an error."""

from itertools import pairwise

import cocotb
import numpy as np
import pytest
from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out
from cocotb.triggers import ClockCycles, RisingEdge

from hw.ctu.ctu_formats import CtuFormats
from hw.ctu.subshell_generator import ListError, SubshellGenerator
from hw.ctu.subshell_table import SubshellTable
from tb.lib.clocking import reset, start
from tb.lib.configurations import config_of
from tb.lib.coverage import Coverage
from tb.lib.no_x import assert_known
from tb.lib.payload import pack
from tb.lib.runner import SIMULATORS, options, simulate
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.stall_patterns import STALL_PAIRS, STALLS
from tb.lib.stream import Sink, Source
from tb.lib.timing import documented_latency

MODULE = "tb.ctu.test_subshell_generator"
CONFIG = config_of({"ctu.subshell_bits": 6})
TABLE, PATCHES, MOST_SHELLS = 64, (1 << CONFIG.icu.patch_bits) - 100, (1 << CONFIG.ctu.shell_bits) - 1
# Bits of a number in the table.
WORD = 32
LAST = {"patch": 0, "shell": 0, "last": 1}


class Listed(wiring.Component):
    """The generator with its table; what comes out says whether there has been an error."""

    def __init__(self, config):
        self._config = config
        self._generator, self._table = SubshellGenerator(config=config), SubshellTable(config=config)
        self.table_latency = self._table.latency
        assert self.table_latency == documented_latency(SubshellTable, config)
        out = StructLayout({"subshell": CtuFormats(config).subshell, "error": ListError})
        super().__init__({
            "i_load": In(self._table.i_load.signature.flip()), "i": In(self._generator.i.signature.flip()),
            "o": Out(stream.Signature(out))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.generator, m.submodules.table = generator, table = self._generator, self._table
        wiring.connect(m, wiring.flipped(self.i), generator.i)
        wiring.connect(m, wiring.flipped(self.i_load), table.i_load)
        wiring.connect(m, generator.o_read, table.i)
        wiring.connect(m, table.o, generator.i_read)
        m.d.comb += [self.o.valid.eq(generator.o.valid), generator.o.ready.eq(self.o.ready),
                     self.o.payload.subshell.eq(generator.o.payload), self.o.payload.error.eq(generator.error)]
        return m


LISTED = Listed(CONFIG)
BENCH = ScheduleBench(LISTED, ["i_load", "i"], ["o"])


def lists(seed):
    """A table, and lists in it: right ones, empty ones, all of the table, and every wrong one."""
    random = np.random.default_rng(seed)
    entries = [{"patch": int(random.integers(PATCHES)), "shell": int(random.integers(1, MOST_SHELLS + 20))}
               for _ in range(TABLE)]
    # Any one of the bits that say that a shell is beyond all.
    for entry in entries[::3]:
        entry["shell"] = 1 << int(random.integers(MOST_SHELLS.bit_length(), WORD))
    entries[20]["patch"] = PATCHES
    entries[30]["patch"] = 1 << int(random.integers(CONFIG.icu.patch_bits, WORD)) | 5
    entries[40]["shell"] = 0
    entries[50]["shell"] = 1 << 31
    whole = {"first": 0, "patches": PATCHES}
    return entries, [
        {**whole, "count": 20}, {**whole, "count": 0}, {**whole, "first": TABLE, "count": 0},
        {**whole, "first": 41, "count": TABLE - 41}, {**whole, "count": TABLE}, {**whole, "first": 15, "count": 9},
        {**whole, "first": 25, "count": 9}, {**whole, "first": 38, "count": 3}, {**whole, "first": 40, "count": 1},
        {**whole, "count": TABLE + 1}, {**whole, "first": 60, "count": 5}, {**whole, "first": TABLE + 1, "count": 0},
        {**whole, "first": 1 << 31, "count": 1 << 31}, {**whole, "first": 3, "count": (1 << 32) - 1},
        {**whole, "first": 1, "count": 12, "patches": 1 << 31}]


def expected(entries, given):
    """Subshells, and the error of the last one."""
    if given["first"] + given["count"] > TABLE:
        return [LAST], ListError.LENGTH
    made = []
    for entry in entries[given["first"]:given["first"] + given["count"]]:
        if entry["patch"] >= given["patches"]:
            return [*made, LAST], ListError.PATCH
        if not entry["shell"]:
            return [*made, LAST], ListError.SHELL
        made.append({"patch": entry["patch"], "shell": min(entry["shell"], MOST_SHELLS), "last": 0})
    return [*made, LAST], ListError.NONE


@pytest.mark.parametrize("stalls", [(), [k * k % 7 for k in range(300)]])
def test_lists_right_and_wrong(stalls):
    entries, given = lists(1)
    coverage = Coverage(["a list", "none", "of the whole table", *(f"error {error.name}" for error in ListError)])
    loads = [(0, {"address": address, **entry}) for address, entry in enumerate(entries)]
    came = BENCH.run(Schedule(
        items={"i_load": loads, "i": [(TABLE + 2 if not number else 0, one) for number, one in enumerate(given)]},
        stalls={"o": list(stalls)}))["o"]
    for number, one in enumerate(given):
        subshells, error = expected(entries, one)
        part, came = came[:len(subshells)], came[len(subshells):]
        assert [item["subshell"] for item in part] == subshells, number
        assert part[-1]["error"] == error.value, number
        assert not any(item["error"] for item in part[:-1])
        coverage.hit_all({"a list": len(subshells) > 1, "none": not one["count"],
                          "of the whole table": one["count"] == TABLE, f"error {error.name}": True})
    assert not came
    coverage.check()


def test_an_entry_per_cycle():
    entries, _ = lists(1)
    came = BENCH.run(Schedule(
        items={"i_load": [(0, {"address": address, **entry}) for address, entry in enumerate(entries)],
               "i": [(TABLE + 2, {"first": 0, "count": 20, "patches": PATCHES}),
                     (9, {"first": 0, "count": 0, "patches": PATCHES})]}, stalls={}))["o"]
    assert len(came) == 22
    begins, leaves = BENCH.cycles["i"], BENCH.cycles["o"]
    assert leaves[0] - begins[0] == documented_latency(SubshellGenerator, CONFIG) + LISTED.table_latency
    assert {b - a for a, b in pairwise(leaves[:20])} == {1}, "entries must leave without a gap"
    assert leaves[21] - begins[1] == 3


def bits(name, value):
    return pack(LISTED.signature.members[name].signature.members["payload"].shape, value)


async def played(dut, source, sink, entries, given, number=0):
    """Some of the lists, one after the other, and what must come of them."""
    given = given[number % 3::3]
    await Source(dut, "i_load").send(
        bits("i_load", {"address": address, **entry}) for address, entry in enumerate(entries))
    starts, taken = Source(dut, "i", stalls=source), Sink(dut, "o", stalls=sink)
    wanted = []
    for one in given:
        subshells, error = expected(entries, one)
        wanted += [bits("o", {"subshell": subshell, "error": error.value if subshell is subshells[-1] else 0})
                   for subshell in subshells]
    await starts.send([bits("i", one) for one in given])
    while len(taken.items) < len(wanted):
        await RisingEdge(dut.clk)
    await ClockCycles(dut.clk, 20)
    assert taken.items == wanted
    taken.stop()


@cocotb.test()
async def every_pair_of_stalls(dut):
    """Under each pair of stall patterns lists come as they are."""
    await start(dut, cycles=100_000)
    for number, (source, sink) in enumerate(STALL_PAIRS):
        await played(dut, STALLS[source](number), STALLS[sink](number + 50), *lists(options()["seed"] + number), number)
        if number == 0:
            assert_known(dut, ["i", "o"])


@cocotb.test()
async def reset_in_flight(dut):
    """Nothing of a list is left after a reset."""
    await start(dut, cycles=20_000)
    entries, given = lists(7)
    for cut in (1, 2, 4, 7, 13):
        sending = cocotb.start_soon(Source(dut, "i").send([bits("i", given[0])]))
        dut.o__ready.value = 1
        await ClockCycles(dut.clk, cut)
        sending.cancel()
        dut.i__valid.value = 0
        await reset(dut)
        await played(dut, None, None, entries, given)


@pytest.mark.parametrize("simulator", [SIMULATORS[0], pytest.param("icarus", marks=pytest.mark.nightly)])
def test_in_the_simulator(simulator):
    simulate(Listed(CONFIG), MODULE, ("every_pair_of_stalls", "reset_in_flight"), simulator=simulator,
             name=f"subshell-generator-{simulator}")
