import pytest
from amaranth.hdl import Module, ResetInserter, Signal
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out
from amaranth.sim import Simulator
from hypothesis import given
from hypothesis import strategies as st

from hw.lib.generations import Generations
from tb.lib.configurations import config_of
from tb.lib.coverage import Coverage
from tb.lib.schedules import SETTINGS
from tb.lib.timing import documented_latency

DEPTH = 5


class Tagged(wiring.Component):
    """A memory's tags as their user keeps them: a write gives a row the current one."""

    def __init__(self, bits):
        super().__init__({"write": In(1), "address": In(range(DEPTH)), "holds": Out(DEPTH)})
        self.generations = Generations(bits=bits, depth=DEPTH)
        self._tags = Memory(shape=bits, depth=DEPTH, init=[])

    def elaborate(self, platform):
        m = Module()
        m.submodules.generations, m.submodules.tags = generations, tags = self.generations, self._tags
        port = tags.write_port()
        with m.If(generations.sweeps):
            m.d.comb += [port.addr.eq(generations.row), port.data.eq(0), port.en.eq(1)]
        with m.Else():
            m.d.comb += [port.addr.eq(self.address), port.data.eq(generations.generation), port.en.eq(self.write)]
        for row in range(DEPTH):
            read = tags.read_port(domain="comb")
            m.d.comb += [read.addr.eq(row), self.holds[row].eq(read.data == generations.generation)]
        return m


class TagsBench:
    """Generations one after the other, each with writes to some rows."""

    def __init__(self, bits):
        self.top, self.reset = Tagged(bits), Signal()

    def run(self, drive):
        """Simulate a coroutine to its end."""
        simulator, ended = Simulator(ResetInserter(self.reset)(self.top)), []

        async def testbench(ctx):
            await drive(ctx)
            ended.append(True)

        simulator.add_clock(1e-8)
        simulator.add_testbench(testbench)
        simulator.run()
        assert ended

    async def begin(self, ctx):
        """Begin a generation, which is empty; the cycles until it was taken."""
        generations, waited, swept = self.top.generations, 0, 0
        ctx.set(generations.i_start.valid, 1)
        ready = False
        while not ready:
            sweeps, ready = ctx.get(generations.sweeps), ctx.get(generations.i_start.ready)
            assert not (sweeps and ready), "nothing begins during a sweep"
            if sweeps:
                assert ctx.get(generations.row) == swept, "every row is swept once, in order"
                swept += 1
            waited += 1
            assert waited <= DEPTH + 1, "the watchdog waited for a generation"
            await ctx.tick()
        ctx.set(generations.i_start.valid, 0)
        assert swept in (0, DEPTH)
        assert ctx.get(generations.generation) != 0, "tag 0 belongs to no item"
        assert ctx.get(self.top.holds) == 0, "a generation begins empty"
        return waited

    async def write(self, ctx, rows):
        """Write rows; they and no others are there then."""
        for row in rows:
            assert not ctx.get(self.top.generations.sweeps)
            ctx.set(self.top.write, 1)
            ctx.set(self.top.address, row)
            await ctx.tick()
            ctx.set(self.top.write, 0)
        assert ctx.get(self.top.holds) == sum(1 << row for row in set(rows))


@pytest.mark.parametrize("bits", [1, 2, 3])
def test_sweeps_come_only_when_tags_run_out(bits):
    bench, last = TagsBench(bits), (1 << bits) - 1
    latency = documented_latency(Generations, config_of({}))
    assert Generations(bits=bits, depth=DEPTH).latency == latency
    coverage = Coverage(["sweep after reset", "sweep when tags ran out", *(["no sweep"] if bits > 1 else [])])

    async def drive(ctx):
        for number in range(2 * last + 2):
            swept = number % last == 0
            assert await bench.begin(ctx) == latency + DEPTH * swept
            coverage.hit("no sweep" if not swept else "sweep when tags ran out" if number else "sweep after reset")
            await bench.write(ctx, [number % DEPTH, (3 * number + 1) % DEPTH])

    bench.run(drive)
    coverage.check()


@SETTINGS
@given(st.integers(1, 3), st.lists(st.tuples(st.integers(0, 9), st.lists(st.integers(0, DEPTH - 1), max_size=6)),
                                   max_size=10))
def test_every_generation_begins_empty_and_keeps_what_it_is_given(bits, frusta):
    bench = TagsBench(bits)

    async def drive(ctx):
        for stall, rows in frusta:
            await ctx.tick().repeat(stall + 1)
            await bench.begin(ctx)
            await bench.write(ctx, rows)

    bench.run(drive)


def test_reset_in_flight():
    """In every cycle of a sweep, and beside it: what was written before is in no generation after."""
    bench = TagsBench(2)

    async def drive(ctx):
        start = bench.top.generations.i_start
        for cut in range(DEPTH + 3):
            for _ in range(3):
                await bench.begin(ctx)
                await bench.write(ctx, range(DEPTH))
            # All tags have been used.
            ctx.set(start.valid, 1)
            if cut:
                await ctx.tick().repeat(cut)
            ctx.set(start.valid, 0)
            ctx.set(bench.reset, 1)
            await ctx.tick()
            ctx.set(bench.reset, 0)
            # A begun sweep goes on from its first row.
            assert await bench.begin(ctx) == DEPTH + 1
            for _ in range(4):
                await bench.begin(ctx)

    bench.run(drive)


class Traffic:
    """Generations of several sizes in a memory that is accessed at any time.

    Parameters
    ----------
    bits
        Of a tag.
    """

    def __init__(self, bits):
        self.bits, self.top = bits, Tagged(bits)
        self.model, self.current, self.swept = [0] * DEPTH, None, 0

    def run(self, frusta):
        """Frusta: rows, cycles in which the memory is idle before, and accesses: a row or None."""
        ended, begins = [], []

        async def testbench(ctx):
            generations = self.top.generations
            for rows, idle, accesses in frusta:
                ctx.set(generations.idle, 1)
                for _ in range(idle):
                    await ctx.tick()
                ctx.set(generations.rows, rows)
                ctx.set(generations.i_start.valid, 1)
                waited = 0
                while not ctx.get(generations.i_start.ready):
                    assert ctx.get(generations.sweeps), "a generation waits for rows that are being swept"
                    assert ctx.get(generations.row) < rows
                    waited += 1
                    await ctx.tick()
                begins.append(waited)
                await ctx.tick()
                ctx.set(generations.i_start.valid, 0)
                ctx.set(generations.idle, 0)
                used = (1 << rows) - 1
                assert ctx.get(self.top.holds) & used == 0, "a generation begins empty"
                there = 0
                for row in accesses:
                    ctx.set(generations.busy, int(row is not None))
                    ctx.set(self.top.write, int(row is not None))
                    if row is not None and rows:
                        ctx.set(self.top.address, row % rows)
                        there |= 1 << row % rows
                    else:
                        ctx.set(self.top.write, 0)
                    assert not (row is not None and ctx.get(generations.sweeps)), "no row is swept beside an access"
                    await ctx.tick()
                    ctx.set(self.top.write, 0)
                    ctx.set(generations.busy, 0)
                    assert ctx.get(self.top.holds) & used == there, "a sweep leaves the rows that are used"
            ended.append(True)

        simulator = Simulator(self.top)
        simulator.add_clock(1e-8)
        simulator.add_testbench(testbench)
        simulator.run()
        assert ended
        return begins


@SETTINGS
@given(st.integers(1, 3), st.lists(st.tuples(
    st.integers(0, DEPTH), st.integers(0, 2 * DEPTH), st.lists(st.none() | st.integers(0, DEPTH - 1), max_size=8)),
    max_size=12))
def test_a_sweep_goes_on_beside_generations_that_use_some_rows(bits, frusta):
    Traffic(bits).run(frusta)


@pytest.mark.parametrize("bits", [1, 2, 3])
def test_a_generation_waits_for_its_own_rows_alone(bits):
    """And for none if the memory was idle for long enough; without idle cycles each further row takes one."""
    last = (1 << bits) - 1
    assert Traffic(bits).run([(DEPTH, DEPTH, [])] * (2 * last)) == [0] * 2 * last
    assert Traffic(bits).run([(2, 0, [])] * (2 * last)) == [2 * (number % last == 0) for number in range(2 * last)]
    if bits > 1:
        # Two rows before generation 1 and one beside its acceptance; one in a cycle without an access.
        assert Traffic(bits).run([(2, 0, [0, None, 1]), (DEPTH, 0, [])]) == [2, DEPTH - 4]
