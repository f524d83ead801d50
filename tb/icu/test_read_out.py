import random
from collections import Counter, deque
from itertools import pairwise, product

import cocotb
import numpy as np
import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import Out
from cocotb.triggers import ClockCycles, RisingEdge

from golden.engine.ctu.sector import Sector
from golden.engine.icu.ray_memory import RayMemory as GoldenRayMemory
from golden.engine.icu.window_walk import ray_address
from golden.engine.stimulus import block
from hw.icu.ray_memory import RayMemory
from hw.icu.read_out import ReadOut
from hw.lib.payload import pack, unpack
from radiosity.flow.package.example.frustum_load import tiles
from tb.lib.clocking import start
from tb.lib.configurations import CONFIGURATIONS, config_of
from tb.lib.no_x import assert_known
from tb.lib.ports import Ports
from tb.lib.runner import SLOW_IN_ICARUS, options, simulate
from tb.lib.scoreboard import check
from tb.lib.stall_patterns import stall_pairs
from tb.lib.timing import documented_latency

# Sixteen tiles of 4 x 4 rays.
SMALL = {"icu.rays": 256, "icu.side_bits": 6, "icu.patch_bits": 8, "icu.generation_bits": 2}
SECTIONS = (Sector(0, 16, 0, 16), Sector(5, 14, 3, 15), Sector(60, 64, 7, 61), Sector(0, 61, 63, 64),
            Sector(9, 10, 2, 3), Sector(33, 34, 6, 17))
# Cycles from an update's answer to its (u, v).
PAYLOAD_DELAYS = (1, 60)


class Banks(wiring.Component):
    """The ray memory with its read-out."""

    def __init__(self, *, config):
        self.memory, self.read_out = RayMemory(config=config, tag=10), ReadOut(config=config)
        memory, read_out = (part.signature.members for part in (self.memory, self.read_out))
        super().__init__({
            "i_start": memory["i_start"], "i_update": memory["i"], "o_update": memory["o"],
            "i_payload": memory["i_payload"], "i_read_out": read_out["i"], "o_hit": read_out["o"], "active": Out(1)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory, m.submodules.read_out = memory, read_out = self.memory, self.read_out
        wiring.connect(m, wiring.flipped(self.i_start), memory.i_start)
        wiring.connect(m, wiring.flipped(self.i_update), memory.i)
        wiring.connect(m, memory.o, wiring.flipped(self.o_update))
        wiring.connect(m, wiring.flipped(self.i_payload), memory.i_payload)
        wiring.connect(m, wiring.flipped(self.i_read_out), read_out.i)
        wiring.connect(m, read_out.o_read, memory.i_read)
        wiring.connect(m, memory.o_read, read_out.i_hit)
        wiring.connect(m, read_out.o, wiring.flipped(self.o_hit))
        m.d.comb += self.active.eq(memory.active)
        return m


class Frustum:
    """Updates of a section's rays, and what they must lead to.

    Parameters
    ----------
    ray, inverse, patch, hit
        Of each update; rays by their number in the section.
    """

    def __init__(self, config, section, ray, inverse, patch, hit):
        self.config, self.section = config, section
        columns, rows = np.meshgrid(np.arange(section.end_column - section.first_column),
                                    np.arange(section.end_row - section.first_row))
        self.columns, self.rows = columns.ravel(), rows.ravel()
        address = ray_address(self.columns, self.rows, tiles(section, config)[0], config.icu)
        self.ray = ray % len(address)
        memory, self.won, self.uv = GoldenRayMemory(len(address), config), [], {}
        uv_high = 1 << config.icu.uv_bits
        self.updates, self.payloads = [], []
        for number, update in enumerate(zip(self.ray, inverse, patch, hit, strict=True)):
            which, *key, meets = map(int, update)
            before = memory.inverse[which], memory.patch[which]
            if meets:
                memory.update(*(np.array([value]) for value in (which, *key)))
            self.won.append(int((memory.inverse[which], memory.patch[which]) != before))
            uv = number * 7 % uv_high, number * 3 % uv_high
            if self.won[-1]:
                self.uv[which] = uv
            self.updates.append({"tag": number, "ray": int(address[which]), "inverse": key[0], "patch": key[1],
                                 "hit": meets})
            self.payloads.append({"ray": int(address[which]), "u": uv[0], "v": uv[1]})
        self.answers = [{"tag": update["tag"], "ray": update["ray"], "inverse": update["inverse"], "won": won}
                        for update, won in zip(self.updates, self.won, strict=True)]
        self.hits = []
        for which, (inverse, patch) in enumerate(zip(memory.inverse.tolist(), memory.patch.tolist(), strict=True)):
            u, v = self.uv.get(which, (0, 0))
            hit = {"inverse": inverse, "patch": patch, "u": u, "v": v} if inverse else {}
            self.hits.append({"column": int(self.columns[which]) + section.first_column,
                              "row": int(self.rows[which]) + section.first_row, "hit": hit,
                              "last": which == len(address) - 1})

    def distances(self):
        """How often an update had one of the same ray so many cycles before, and whether those two won."""
        return Counter((ahead, self.won[k - ahead], self.won[k]) for ahead in range(1, 7)
                       for k in range(ahead, len(self.ray)) if self.ray[k] == self.ray[k - ahead])


def random_frustum(config, section, seed, count=300):
    """Golden's stimulus; a fifth of the rays miss their patch."""
    generator = np.random.default_rng(seed)
    given = block("icu.ray_memory")[1].draw(generator, count, config)
    return Frustum(config, section, given["ray"], given["inverse"], given["patch"], generator.random(count) < 0.8)


def hammer(config, section, ahead, seed=None):
    """The same ray every ``ahead`` cycles: ever nearer, ever farther, equal with other ids, and all of that mixed.

    Numbers differ in their low bits alone; the others are random with a ``seed``, and without 0.
    """
    number, high = np.arange(40), config.numbers.inverse.high
    generator = np.random.default_rng(ahead)
    inverse = np.concatenate([1 + number, 99 - number, np.full(40, 50), generator.integers(45, 55, 120)])
    patch = np.concatenate([number, number, (40 - number) ^ 2, generator.integers(0, 4, 120)])
    if seed is not None:
        inverse, patch = (values + (int(np.random.default_rng(seed).integers(1 << bits - 7)) << 7)
                          for values, bits in ((inverse, high.bit_length()), (patch, config.icu.patch_bits)))
    inverse[-1] = high
    return Frustum(config, section, np.arange(len(inverse)) % ahead, inverse, patch, np.ones(len(inverse), dtype=bool))


class BanksBench:
    """The streams of the banks; (u, v) of wins come some cycles after the answers."""

    def __init__(self, dut, *, updates="none", hits="none", delay=1):
        self.config = config_of(options()["changes"])
        self.ports = Ports(dut, Banks(config=self.config), stalls={"i_update": updates, "o_hit": hits})
        self.dut, self.answer, self.hit = dut, self.ports.sinks["o_update"], self.ports.sinks["o_hit"]
        self.delay = delay

    async def cast(self, frustum):
        """Begin a frustum and send its updates; all answers are right, and all (u, v) are written."""
        self.answer.items.clear()
        await self.ports.send("i_start", [0])
        writes = self.ports.run(self._write(frustum))
        await self.ports.send("i_update", frustum.updates)
        await writes
        check(self.ports.payloads["o_update"], self.answer.items, frustum.answers, what="o_update")

    async def _write(self, frustum):
        source = self.ports.sources["i_payload"]
        waiting, done = deque([None] * (self.delay - 1)), 0
        while done < len(frustum.updates):
            await self.ports.edge
            won = None
            if int(self.dut.o_update__valid.value):
                answer = unpack(self.ports.payloads["o_update"], int(self.dut.o_update__payload.value))
                done += 1
                won = frustum.payloads[answer["tag"]] if answer["won"] else None
            waiting.append(won)
            self._give(source, waiting.popleft())
        for write in waiting:
            await self.ports.edge
            self._give(source, write)
        await self.ports.edge
        source.valid.value = 0

    def _give(self, source, write):
        source.valid.value = int(write is not None)
        if write is not None:
            source.payload.value = pack(self.ports.payloads["i_payload"], write)

    async def hits_of(self, frustum, bank=None):
        """Read a bank, by default the one of the last frustum, and compare it."""
        bank = self.ports["active"] if bank is None else bank
        self.hit.items.clear()
        self.hit.cycles.clear()
        section = frustum.section
        await self.ports.send("i_read_out", [{
            "bank": bank, "tiles_across": tiles(section, self.config)[0],
            "section": {name: getattr(section, name) for name in
                        ("first_column", "end_column", "first_row", "end_row")}}])
        await self.ports.until(lambda: len(self.hit.items) >= len(frustum.hits))
        await ClockCycles(self.dut.clk, 20)
        check(self.ports.payloads["o_hit"], self.hit.items, frustum.hits, what="o_hit")


def assert_no_gap(monitor, what):
    """One was transferred per cycle."""
    assert {b - a for a, b in pairwise(monitor.cycles)} <= {1}, f"{what} must come without a gap"


@cocotb.test()
async def every_section(dut):
    """Sections of all forms, over more frusta than there are tags; every answer and every hit, one per cycle."""
    await start(dut, cycles=60_000)
    for delay in PAYLOAD_DELAYS:
        bench = BanksBench(dut, delay=delay)
        await RisingEdge(dut.clk)
        assert_known(dut, [*bench.ports.sources, *bench.ports.sinks])
        for seed, section in enumerate(SECTIONS * 2):
            frustum = random_frustum(bench.config, section, seed + options()["seed"])
            await bench.cast(frustum)
            await bench.hits_of(frustum)
            assert_no_gap(bench.hit, "hits")
        bench.ports.stop()


@cocotb.test()
async def the_same_ray_after_every_number_of_cycles(dut):
    """Consecutive updates of one ray, of two rays by turns, and so on past the depth of the update."""
    await start(dut, cycles=60_000)
    seen = Counter()
    bench = BanksBench(dut)
    # Frusta of every kind come to both banks, as there is an odd number of seeds.
    for ahead, seed in product(range(1, 9), (None, 1, 2, 3, 4)):
        frustum = hammer(bench.config, SECTIONS[0], ahead, seed)
        seen += frustum.distances()
        await bench.cast(frustum)
        await bench.hits_of(frustum)
    missing = [(ahead, before, now) for ahead in range(1, 7) for before in (0, 1) for now in (0, 1)
               if not seen[ahead, before, now]]
    assert not missing, f"no update was (cycles after, won before, won) {missing}"


@cocotb.test()
async def every_pair_of_stalls(dut):
    """A bank is read under back-pressure while the other one is updated."""
    await start(dut, cycles=200_000)
    before = None
    for number, (updates, hits) in enumerate(stall_pairs()):
        bench = BanksBench(dut, updates=updates, hits=hits, delay=PAYLOAD_DELAYS[number % 2])
        frustum = random_frustum(bench.config, SECTIONS[number % 3], number + options()["seed"])
        reads = before and cocotb.start_soon(bench.hits_of(before, bank=bench.ports["active"]))
        await bench.cast(frustum)
        if reads:
            await reads
        bench.ports.stop()
        before = frustum


@cocotb.test()
async def reset_in_flight(dut):
    """What was written before a reset is seen by no frustum after it, in either bank, whatever its tag."""
    await start(dut, cycles=100_000)
    generator = random.Random(options()["seed"])
    for before in range(4):
        bench = BanksBench(dut, hits="random")
        everything = random_frustum(bench.config, SECTIONS[0], before)
        for _ in range(before):
            await bench.cast(everything)
        await bench.ports.send("i_start", [0])
        bench.ports.begin("i_update", everything.updates)
        bench.ports.run(bench.hits_of(everything, bank=1 - bench.ports["active"]))
        await ClockCycles(dut.clk, generator.randrange(5, 200))
        await bench.ports.reset()
        bench.ports.stop()
        bench = BanksBench(dut)
        nothing = Frustum(bench.config, SECTIONS[0], *np.zeros((4, 0), dtype=int))
        for _ in range(9):
            await bench.cast(nothing)
            await bench.hits_of(nothing)
        await bench.cast(everything)
        await bench.hits_of(everything)
        bench.ports.stop()


@cocotb.test()
async def one_per_cycle(dut):
    """Updates and hits come one per cycle, both at once, after the latencies that the docstrings state."""
    await start(dut, cycles=20_000)
    bench = BanksBench(dut)
    first, second = (random_frustum(bench.config, SECTIONS[0], seed) for seed in (1, 2))
    await bench.cast(first)
    given, read_outs = bench.ports.taken("i_update"), bench.ports.taken("i_read_out")
    bench.answer.cycles.clear()
    bank = bench.ports["active"]
    await bench.ports.send("i_start", [0])
    writes = bench.ports.begin("i_update", second.updates)
    await bench.hits_of(first, bank=bank)
    await writes
    for monitor, what in ((given, "updates"), (bench.answer, "answers"), (bench.hit, "hits")):
        assert_no_gap(monitor, what)
    assert bench.answer.cycles[0] - given.cycles[0] == documented_latency(RayMemory, bench.config)
    assert bench.hit.cycles[0] - read_outs.cycles[0] == documented_latency(ReadOut, bench.config)


def run(changes, simulator="verilator"):
    changes = {**SMALL, **changes}
    banks = Banks(config=config_of(changes))
    assert banks.memory.latency == documented_latency(RayMemory, config_of(changes))
    simulate(banks, __name__, simulator=simulator, changes=changes)


@pytest.mark.parametrize("simulator", SLOW_IN_ICARUS)
def test_in_the_simulator(simulator):
    run({}, simulator)


@pytest.mark.nightly
def test_one_tag_and_narrow_numbers():
    run({**CONFIGURATIONS["narrow"], "icu.generation_bits": 1, "icu.tile_bits": 1})
