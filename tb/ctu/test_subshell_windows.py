# amaranth: UnusedElaboratable=no

"""The windows of subshells are golden's, with few multipliers."""

from itertools import count, pairwise

import cocotb
import pytest
from amaranth.sim import Simulator
from cocotb.triggers import ClockCycles, RisingEdge

from hw.ctu.subshell_windows import SubshellWindows
from tb.ctu.subshell_patches import CASES, SubshellPatches
from tb.lib.clocking import reset, start
from tb.lib.configurations import CONFIGURATIONS, config_of
from tb.lib.coverage import Coverage
from tb.lib.no_x import assert_known
from tb.lib.payload import pack, unpack
from tb.lib.runner import SIMULATORS, options, simulate
from tb.lib.stall_patterns import STALL_PAIRS, STALLS
from tb.lib.stream import Monitor, Sink, Source

MODULE = "tb.ctu.test_subshell_windows"
RUNS = [("hemisphere", 3), ("screen", 4), ("hemisphere", 5)]
# Patches at the borders of rays, of each of these.
AT_BORDERS = 240
# Cycles from a subshell's patch to the next one's.
RATE = 64
VARIANTS = [({"icu.product_registers": 1}, 18), pytest.param({}, 15, marks=pytest.mark.nightly),
            pytest.param({**CONFIGURATIONS["narrow"], "icu.product_registers": 3}, 20, marks=pytest.mark.nightly)]


def make(config, **arguments):
    return SubshellWindows(config=config, **arguments)


def check(came, given):
    """``came``: the payloads in their order."""
    assert len(came) == len(given.windows)
    for number, (got, wanted) in enumerate(zip(came, given.windows, strict=True)):
        if wanted["last"]:
            assert got["last"], number
        else:
            assert got == wanted, number


def run(component, given, *, source="none", sink="none", seed=1):
    """What comes out in Amaranth's simulator, with the cycles, and the cycles of the patches' first vertices."""
    stalls, stops = STALLS[source](seed), STALLS[sink](seed + 1)
    came, cycles, entered = [], [], []

    async def drive(ctx):
        for name, value in given.ports.items():
            ctx.set(getattr(component, name), value)
        for write in given.tables:
            ctx.set(component.i_table.payload, write)
            ctx.set(component.i_table.valid, 1)
            await ctx.tick()
        ctx.set(component.i_table.valid, 0)
        for item in given.items:
            while next(stalls):
                await ctx.tick()
            ctx.set(component.i.payload, item)
            ctx.set(component.i.valid, 1)
            await ctx.tick().until(component.i.ready)
            ctx.set(component.i.valid, 0)

    async def read(ctx):
        """The patches' memory."""
        beats = []
        ctx.set(component.o_patch.ready, 1)
        while True:
            ctx.set(component.i_vertex.valid, bool(beats))
            if beats:
                ctx.set(component.i_vertex.payload, beats[0])
            *_, valid, patch, taken = await ctx.tick().sample(
                component.o_patch.valid, component.o_patch.payload, component.i_vertex.valid & component.i_vertex.ready)
            beats = beats[taken:] + (given.beats(patch) if valid else [])

    async def take(ctx):
        cycle, vertices = 0, 0
        while len(came) < len(given.windows):
            ctx.set(component.o.ready, not next(stops))
            *_, ready, valid, payload, enters = await ctx.tick().sample(
                component.o.ready, component.o.valid, component.o.payload.as_value(),
                component.i_vertex.valid & component.i_vertex.ready)
            cycle += 1
            assert cycle < 100_000, "the bench hangs"
            if enters:
                if vertices % 4 == 0:
                    entered.append(cycle)
                vertices += 1
            if ready and valid:
                came.append(unpack(component.o.payload.shape(), payload))
                cycles.append(cycle)

    simulator = Simulator(component)
    simulator.add_clock(1e-8)
    simulator.add_testbench(drive)
    simulator.add_testbench(take)
    simulator.add_testbench(read, background=True)
    simulator.run()
    return came, cycles, entered


@pytest.mark.parametrize(("changes", "interval"), VARIANTS)
def test_windows_of_screens_and_hemispheres(changes, interval):
    config = config_of(changes)
    given = SubshellPatches("screen", config, seed=4, count=9)
    check(run(make(config, interval=interval), given, source="random", sink="bursts")[0], given)


def test_a_window_every_four_intervals_after_the_latency():
    config = config_of({})
    component, given = make(config), SubshellPatches("hemisphere", config, seed=3, count=12)
    came, cycles, entered = run(component, given)
    check(came, given)
    assert {b - a for a, b in pairwise(entered)} == {RATE}, "patches must be taken without a gap"
    first = next(number for number, patch in enumerate(given.patches) if given.kept[patch])
    assert cycles[0] - entered[first] == component.latency


def test_the_subshells_hold_every_case():
    coverage = Coverage(CASES)
    for kind, seed in RUNS:
        SubshellPatches(kind, config_of({}), seed=seed, count=200).hit(coverage)
    coverage.check()


class Bench:
    """The streams in a cocotb simulator, and the patches' memory."""

    def __init__(self, dut, given, *, source="none", sink="none", seed=0):
        component = make(given.config)
        self.dut, self.given = dut, given
        self._shapes = {name: getattr(component, name).payload.shape() for name in ("i", "i_table", "i_vertex", "o")}
        self._ports = {name: pack(component.signature.members[name].shape, value)
                       for name, value in given.ports.items()}
        self.source, self.table = Source(dut, "i", stalls=STALLS[source](seed)), Source(dut, "i_table")
        self.asked, self.vertex = Sink(dut, "o_patch", stalls=STALLS[source](seed + 20)), Source(dut, "i_vertex")
        self.sink = Sink(dut, "o", stalls=STALLS[sink](seed + 50))
        self._memory = cocotb.start_soon(self._answer())

    async def _answer(self):
        for number in count():
            while len(self.asked.items) <= number:
                await RisingEdge(self.dut.clk)
            await self.vertex.send(pack(self._shapes["i_vertex"], beat)
                                   for beat in self.given.beats(self.asked.items[number]))

    async def prepare(self):
        for name, value in self._ports.items():
            getattr(self.dut, name).value = value
        await self.table.send(pack(self._shapes["i_table"], write) for write in self.given.tables)

    def send(self):
        return self.source.send([pack(self._shapes["i"], item) for item in self.given.items])

    async def run(self):
        await self.send()
        while len(self.sink.items) < len(self.given.windows):
            await RisingEdge(self.dut.clk)
        await ClockCycles(self.dut.clk, 400)
        check([unpack(self._shapes["o"], item) for item in self.sink.items], self.given)
        assert self.asked.items == self.given.patches.tolist()

    def stop(self):
        self._memory.cancel()
        for end in (self.sink, self.asked):
            end.stop()
        for source in (self.source, self.table, self.vertex):
            source.valid.value = 0


@cocotb.test()
async def every_pair_of_stalls(dut):
    """The windows are the same under each pair of stall patterns, frustum after frustum."""
    await start(dut, cycles=600_000)
    for number, (source, sink) in enumerate(STALL_PAIRS):
        given = SubshellPatches(("hemisphere", "screen")[number % 2], config_of({}), count=12,
                                seed=options()["seed"] * 100 + number)
        bench = Bench(dut, given, source=source, sink=sink, seed=number)
        await bench.prepare()
        if number == 0:
            assert_known(dut, ["i", "i_vertex", "o_patch", "o"])
        await bench.run()
        bench.stop()


@cocotb.test()
async def windows_at_borders(dut):
    """In the largest frusta, of patches for whose windows the low bits matter."""
    await start(dut, cycles=200_000)
    config = config_of({})
    for kind, seed in RUNS:
        given = SubshellPatches(kind, config, seed=seed, count=AT_BORDERS, size=(1 << config.icu.side_bits,) * 2,
                                at_borders=True)
        bench = Bench(dut, given)
        await bench.prepare()
        await bench.run()
        bench.stop()


@cocotb.test()
async def reset_in_flight(dut):
    """Nothing of what was in flight comes out after a reset."""
    await start(dut, cycles=200_000)
    for cut in (3, 90, 250, 333, 500):
        given = SubshellPatches("hemisphere", config_of({}), count=9, seed=cut)
        bench = Bench(dut, given)
        await bench.prepare()
        sending = cocotb.start_soon(bench.send())
        await ClockCycles(dut.clk, cut)
        sending.cancel()
        bench.stop()
        await reset(dut)
        bench = Bench(dut, given)
        await bench.prepare()
        await bench.run()
        bench.stop()


@cocotb.test()
async def one_patch_every_four_intervals(dut):
    """Without stalls patches are taken without a gap, and their windows come after the latency."""
    await start(dut, cycles=50_000)
    given = SubshellPatches("hemisphere", config_of({}), count=40, seed=3)
    bench = Bench(dut, given)
    await bench.prepare()
    entered = Monitor(dut, "i_vertex")
    await bench.run()
    first = entered.cycles[::4]
    assert {b - a for a, b in pairwise(first)} == {RATE}
    kept = next(number for number, patch in enumerate(given.patches) if given.kept[patch])
    assert bench.sink.cycles[0] - first[kept] == make(given.config).latency


@pytest.mark.parametrize("simulator", [SIMULATORS[0], pytest.param("icarus", marks=pytest.mark.nightly)])
def test_in_the_simulator(simulator):
    simulate(make(config_of({})), MODULE,
             ("every_pair_of_stalls", "windows_at_borders", "reset_in_flight", "one_patch_every_four_intervals"),
             simulator=simulator, name=f"subshell-windows-{simulator}")


@pytest.mark.parametrize(("value", "error"), [(14, ValueError), (18.0, TypeError)])
def test_init_wrong_interval(value, error):
    with pytest.raises(error, match=f"^Interval must be at least 15, not {value!r}$"):
        make(config_of({}), interval=value)
