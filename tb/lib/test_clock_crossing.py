"""Streams between clocks of any ratio, with stalls and resets."""

import math
import random

import pytest
from amaranth.hdl import ClockDomain, Module, Signal
from amaranth.lib.data import StructLayout

from hw.lib.clock_crossing import ClockCrossing
from tb.lib.seed import SEED
from tb.lib.simulator import simulator_of
from tb.lib.stall_patterns import STALLS

SHAPE = StructLayout({"number": 16, "inverted": 16})
# Nanoseconds of a cycle of the source and of the sink.
PERIODS = [(10, 10), (10, 3), (3, 10), (7, 11), (10, 10.1)]
# Cycles of the slower clock after which a simulation is stuck.
WATCHDOG = 3000


class Crossing:
    """A crossing between two clocks, whose phases are drawn.

    Members
    -------
    sent, came
        Numbers of items, and how many cycles of source and sink had passed when they were accepted.
    """

    def __init__(self, periods, *, depth=16, seed=SEED):
        self.dut = ClockCrossing(SHAPE, source="source", sink="sink", depth=depth)
        self.sent, self.came = [], []
        self.cycles = [Signal(32) for _ in range(2)]
        m = Module()
        m.submodules.dut = self.dut
        self.domains = [ClockDomain(name) for name in ("source", "sink")]
        m.domains += self.domains
        for domain, cycles in zip(self.domains, self.cycles, strict=True):
            m.d[domain.name] += cycles.eq(cycles + 1)
        self.simulator = simulator_of(m, period=None)
        self._random = random.Random(seed)
        for domain, period in zip(self.domains, periods, strict=True):
            self.simulator.add_clock(period * 1e-9, phase=self._random.random() * period * 1e-9, domain=domain.name)

    def now(self, ctx):
        return tuple(ctx.get(cycles) for cycles in self.cycles)

    async def source(self, ctx, numbers, pattern):
        for number in numbers:
            while next(pattern):
                await ctx.tick("source")
            ctx.set(self.dut.i.payload, {"number": number, "inverted": ~number & 0xFFFF})
            ctx.set(self.dut.i.valid, 1)
            _, _, ready = await ctx.tick("source").sample(self.dut.i.ready)
            while not ready:
                _, _, ready = await ctx.tick("source").sample(self.dut.i.ready)
            self.sent.append((number, self.now(ctx)))
            ctx.set(self.dut.i.valid, 0)

    async def sink(self, ctx, pattern):
        while True:
            ctx.set(self.dut.o.ready, not next(pattern))
            _, _, valid, ready, payload = await ctx.tick("sink").sample(self.dut.o.valid, self.dut.o.ready,
                                                                       self.dut.o.payload)
            if valid and ready:
                assert payload.inverted == ~payload.number & 0xFFFF
                self.came.append((payload.number, self.now(ctx)))

    def run(self, *, count, patterns=("none", "none"), seed=SEED):
        """Send numbers until all have come."""
        source, sink = (STALLS[name](seed + k) for k, name in enumerate(patterns))

        async def wait(ctx):
            await self.source(ctx, range(count), source)
            cycles = 0
            while len(self.came) < count:
                await ctx.tick("source")
                cycles += 1
                assert cycles < WATCHDOG, f"{len(self.came)} of {count} items came"

        self.simulate(wait, sink)
        return self

    def simulate(self, bench, pattern):
        """Run a testbench of the source while the sink takes items."""
        async def take(ctx):
            await self.sink(ctx, pattern)
        self.simulator.add_testbench(bench)
        self.simulator.add_testbench(take, background=True)
        self.simulator.run()


@pytest.mark.parametrize("periods", PERIODS)
@pytest.mark.parametrize("patterns", [("none", "none"), ("random", "bursts"), ("bursts", "random"), ("none", "stop"),
                                      ("alternating", "none")])
def test_items_come_once_and_in_order(periods, patterns):
    crossing = Crossing(periods).run(count=50, patterns=patterns)
    assert [number for number, _ in crossing.came] == list(range(50))


@pytest.mark.parametrize("periods", PERIODS)
def test_the_slower_clock_has_one_item_per_cycle_and_the_latency_is_stated(periods):
    crossing = Crossing(periods).run(count=80)
    slower = int(periods[1] > periods[0])
    cycles = [passed[slower] for _, passed in crossing.came]
    assert cycles[-1] - cycles[20] <= 60
    # One cycle of the source, two or three of the sink, and the one in which the item is taken.
    source, sink = periods
    first = crossing.came[0][1][1] - crossing.sent[0][1][1]
    assert 3 <= first <= 4 + math.ceil(source / sink)


@pytest.mark.parametrize("depth", [4, 16])
def test_its_depth_is_in_flight_while_nothing_is_taken(depth):
    crossing = Crossing((10, 7), depth=depth)

    async def fill(ctx):
        ctx.set(crossing.dut.i.valid, 1)
        accepted = 0
        for _ in range(4 * depth):
            _, _, ready = await ctx.tick("source").sample(crossing.dut.i.ready)
            accepted += ready
        assert accepted == depth
    crossing.simulator.add_testbench(fill)
    crossing.simulator.run()


@pytest.mark.parametrize("periods", PERIODS)
@pytest.mark.parametrize("seed", [SEED])
def test_items_of_before_a_reset_of_both_sides_never_come(periods, seed):
    crossing, draw = Crossing(periods, seed=seed), random.Random(seed)
    source, sink = crossing.domains
    dut = crossing.dut

    async def bench(ctx):
        ctx.set(dut.i.valid, 1)
        for number in range(draw.randint(1, 40)):
            ctx.set(dut.i.payload, {"number": 0x8000 + number, "inverted": ~(0x8000 + number) & 0xFFFF})
            await ctx.tick("source")
        ctx.set(source.rst, 1)
        ctx.set(sink.rst, 1)
        await ctx.tick("sink")
        crossing.came.clear()
        for _ in range(draw.randint(4, 9)):
            _, _, ready = await ctx.tick("source").sample(dut.i.ready)
            assert not ready
        ctx.set(dut.i.valid, 0)
        await ctx.delay(10 * max(periods) * 1e-9)
        assert not ctx.get(dut.o.valid)
        assert not crossing.came
        # Either side may end its reset first; what it sends to the other waits.
        source_first, pattern = draw.random() < 0.5, STALLS["random"](seed)
        ctx.set((source if source_first else sink).rst, 0)
        await ctx.delay(draw.random() * 60e-9)
        if source_first:
            await crossing.source(ctx, range(4), pattern)
            await ctx.delay(draw.random() * 100e-9)
            assert not crossing.came
        ctx.set((sink if source_first else source).rst, 0)
        await crossing.source(ctx, range(4 if source_first else 0, 50), pattern)
        await ctx.delay(20 * max(periods) * 1e-9)
        assert [number for number, _ in crossing.came] == list(range(50))
    crossing.simulate(bench, STALLS["none"](seed))


@pytest.mark.parametrize(("depth", "error"), [(2, ValueError), (12, ValueError), (16.0, TypeError)])
def test_init_wrong_depth(depth, error):
    with pytest.raises(error, match=f"^Depth must be a power of two, at least 4, not {depth!r}$"):
        ClockCrossing(SHAPE, source="source", sink="sink", depth=depth)


@pytest.mark.parametrize("periods", PERIODS)
def test_an_item_that_leaves_makes_room_within_the_stated_cycles(periods):
    crossing = Crossing(periods, depth=4)
    dut, (source, sink) = crossing.dut, periods

    async def bench(ctx):
        ctx.set(dut.i.valid, 1)
        for _ in range(20 + 20 * math.ceil(sink / source)):
            await ctx.tick("source")
        assert not ctx.get(dut.i.ready)
        ctx.set(dut.o.ready, 1)
        await ctx.tick("sink")
        ctx.set(dut.o.ready, 0)
        begin, cycles = crossing.now(ctx)[0], 0
        while not ctx.get(dut.i.ready):
            await ctx.tick("source")
            cycles += 1
            assert cycles < WATCHDOG
        assert crossing.now(ctx)[0] - begin <= 4 + math.ceil(sink / source)
    crossing.simulator.add_testbench(bench)
    crossing.simulator.run()


@pytest.mark.parametrize("periods", [*PERIODS, (5, 17), (17, 5)])
@pytest.mark.parametrize("seed", [SEED, pytest.param(SEED + 1, marks=pytest.mark.sim)])
def test_resets_that_overlap_for_three_edges_of_both_clocks_suffice(periods, seed):
    crossing, draw = Crossing(periods, seed=seed), random.Random(seed)

    async def bench(ctx):
        ctx.set(crossing.dut.i.payload, {"number": 0x8000, "inverted": 0x7FFF})
        ctx.set(crossing.dut.i.valid, 1)
        for _ in range(draw.randint(1, 60)):
            await ctx.tick("source")
        await ctx.delay(draw.random() * 20e-9)
        ctx.set(crossing.dut.i.valid, 0)
        for domain in crossing.domains:
            ctx.set(domain.rst, 1)
        for _ in range(3):
            await ctx.tick(("source", "sink")[int(periods[1] > periods[0])])
        for domain in crossing.domains:
            ctx.set(domain.rst, 0)
        crossing.came.clear()
        await crossing.source(ctx, range(20), STALLS["none"](seed))
        await ctx.delay(30 * max(periods) * 1e-9)
        assert [number for number, _ in crossing.came] == list(range(20))
    crossing.simulate(bench, STALLS["none"](seed))
