"""The bench of a block with one input stream: vectors in, expected vectors out, in all regimes.

`check_block` runs a block of any configuration in Amaranth's own simulator, which needs no build; `check_in_simulator`
runs it in Verilator or Icarus under every pair of stall patterns, with a reset in flight, and counts cycles.
"""

import json
import random
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise
from pathlib import Path

import cocotb
from amaranth.sim import Simulator
from cocotb.triggers import ClockCycles, RisingEdge

from golden.config import Config
from tb.lib.clocking import reset, start
from tb.lib.configurations import CONFIGURATIONS, DEPTHS, config_of
from tb.lib.no_x import assert_known
from tb.lib.payload import pack
from tb.lib.runner import BUILD, options, simulate
from tb.lib.scoreboard import check
from tb.lib.stall_patterns import STALL_PAIRS, STALLS
from tb.lib.stream import Monitor, Sink, Source
from tb.lib.timing import documented_latency

__all__ = ["VARIANTS", "Vectors", "check_block", "check_in_simulator"]

# The widths at every depth of the pipelines.
VARIANTS = [{**widths, "icu.product_registers": depth} for widths in CONFIGURATIONS.values() for depth in DEPTHS]
# Items of a case under each pair of stall patterns: more of them find nothing more, and all come without stalls.
STALLED = 100


@dataclass(kw_only=True)
class Vectors:
    """What a block is given, and what it must answer.

    Parameters
    ----------
    items
        Payloads of the input stream ``i``.
    expected
        Payloads of each output stream.
    ports
        Values of its other inputs, which stay.
    tables
        Payloads of ``i_table``, written first.
    """

    items: list
    expected: dict[str, list]
    ports: dict = field(default_factory=dict)
    tables: list = field(default_factory=list)


def check_block(make: Callable, vectors: Callable[[Config], Vectors], *, interval: int = 1, seed: int = 1,
                items_per_result: int = 1, variants=VARIANTS, more: dict | None = None) -> None:
    """Every variant answers as expected, with and without gaps, after the latency that its docstring states.

    Parameters
    ----------
    make
        From a configuration to the component.
    vectors
        From a configuration to the vectors.
    interval
        Least cycles between items.
    items_per_result
        Inputs of one output; the latency counts from the last one.
    more
        Names in the docstring's formula that are no parameters of the configuration.
    """
    for changes in variants:
        config = config_of(changes)
        component, given = make(config), vectors(config)
        assert component.latency == documented_latency(type(component), config, **(more or {})), changes
        came, latency = _run(component, given, interval, random.Random(seed), items_per_result)
        assert latency == component.latency, changes
        for name, expected in given.expected.items():
            shape = _shape(component, name)
            check(shape, came[name], [pack(shape, value) for value in expected], what=f"{name} with {changes}")


def check_in_simulator(name: str, make: Callable, *cases: Callable[[Config], Vectors], simulator: str,
                       interval: int = 1, text: Callable | None = None) -> None:
    """The default configuration in another simulator: stalls, reset in flight, one item per ``interval`` cycles.

    Parameters
    ----------
    cases
        From a configuration to vectors. Ports and tables are those of one case after the other.
    text
        From the component to its Verilog, with a module ``top``. Default: as it is exported.
    """
    config = config_of({})
    component = make(config)
    path = BUILD / "vectors" / f"{name}-{simulator}.json"
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(json.dumps({
        "interval": interval, "latency": component.latency,
        "cases": [_packed(component, vectors(config)) for vectors in cases]}))
    simulate(text(component) if text else component, "tb.lib.block_bench",
             ("every_pair_of_stalls", "reset_in_flight", "one_item_per_interval"), simulator=simulator,
             name=f"{name}-{simulator}", vectors=str(path.resolve()))


def _packed(component, given):
    """Vectors as the words of ports."""
    return {"ports": {port: pack(component.signature.members[port].shape, value)
                      for port, value in given.ports.items()},
            "tables": [pack(_shape(component, "i_table"), value) for value in given.tables],
            "items": [pack(_shape(component, "i"), value) for value in given.items],
            "expected": {stream: [pack(_shape(component, stream), value) for value in values]
                         for stream, values in given.expected.items()}}


def _shape(component, stream):
    return component.signature.members[stream].signature.members["payload"].shape


def _run(component, given, interval, generator, items_per_result):
    """What came out of Amaranth's simulator, and after how many cycles the first result did."""
    came, times = {name: [] for name in given.expected}, {"in": [], **{name: [] for name in given.expected}}
    packed = [pack(_shape(component, "i"), item) for item in given.items]
    simulator = Simulator(component)
    simulator.add_clock(1e-8)
    done = []

    async def drive(ctx):
        for port, value in given.ports.items():
            ctx.set(getattr(component, port), value)
        for output in (getattr(component, name) for name in came):
            if not output.signature.always_ready:
                ctx.set(output.ready, 1)
        for write in given.tables:
            ctx.set(component.i_table.payload, write)
            ctx.set(component.i_table.valid, 1)
            await ctx.tick()
        if given.tables:
            ctx.set(component.i_table.valid, 0)
        for number, item in enumerate(packed):
            ctx.set(component.i.payload.as_value(), item)
            ctx.set(component.i.valid, 1)
            await ctx.tick()
            # The second half comes with random gaps.
            gap = generator.randrange(4) if number > len(packed) // 2 and number % items_per_result == 0 else 0
            if interval - 1 + gap:
                ctx.set(component.i.valid, 0)
                await ctx.tick().repeat(interval - 1 + gap)
        ctx.set(component.i.valid, 0)
        await ctx.tick().repeat(component.latency + 4)
        done.append(True)

    async def watch(ctx):
        cycle, streams = 0, [component.i, *(getattr(component, name) for name in came)]
        while not done:
            sampled = await ctx.tick().sample(*(signal for stream in streams for signal in (
                stream.valid, stream.payload.as_value() if hasattr(stream.payload, "as_value") else stream.payload)))
            values = sampled[2:]
            cycle += 1
            if values[0]:
                times["in"].append(cycle)
            for k, name in enumerate(came, 1):
                if values[2 * k]:
                    came[name].append(int(values[2 * k + 1]))
                    times[name].append(cycle)

    simulator.add_testbench(drive)
    simulator.add_testbench(watch)
    simulator.run()
    last = list(came)[-1]
    return came, times[last][0] - times["in"][items_per_result - 1]


class _Bench:
    """A block in the simulator, with one case of its vectors."""

    def __init__(self, dut, given, source_stalls="none", sink_stalls="none"):
        self.given = given
        seed = options()["seed"]
        stalls = STALLS[source_stalls](seed)
        if given["interval"] > 1:
            stalls = _spaced(stalls, given["interval"])
        self.dut, self.source = dut, Source(dut, "i", stalls=stalls)
        self.sinks = {name: Sink(dut, name, stalls=STALLS[sink_stalls](seed + 1)) for name in given["expected"]}

    async def prepare(self):
        """Ports and tables."""
        for port, value in self.given["ports"].items():
            getattr(self.dut, port).value = value
        if self.given["tables"]:
            await Source(self.dut, "i_table").send(self.given["tables"])

    async def finish(self, count):
        """Wait until all has come that must come of the first ``count`` items, and a while for more."""
        while any(len(sink.items) < self.wanted(name, count) for name, sink in self.sinks.items()):
            await RisingEdge(self.dut.clk)
        await ClockCycles(self.dut.clk, self.given["latency"] + 4)
        for name, sink in self.sinks.items():
            expected = self.given["expected"][name][:self.wanted(name, count)]
            assert sink.items == expected, f"{name}: item {_first(sink.items, expected)} differs"
            sink.stop()

    def wanted(self, name, count):
        """Results of the first ``count`` items."""
        return len(self.given["expected"][name]) * count // len(self.given["items"])


def _cases():
    """The vectors of each case."""
    given = json.loads(Path(options()["vectors"]).read_text())
    cases = given.pop("cases")
    return [given | case for case in cases]


def _cycles(cases, rounds):
    """More than ``rounds`` times all items can take."""
    return 5_000 + 16 * rounds * sum(given["interval"] * len(given["items"]) + given["latency"] for given in cases)


def _stalled(given):
    """How many items of a case come under each pair of stall patterns, in whole groups of four."""
    return min(len(given["items"]) // 4, STALLED) & ~3


def _first(got, expected):
    different = (k for k, (a, b) in enumerate(zip(got, expected, strict=False)) if a != b)
    return next(different, min(len(got), len(expected)))


def _spaced(stalls, interval):
    while True:
        yield next(stalls)
        yield from [True] * (interval - 1)


@cocotb.test()
async def every_pair_of_stalls(dut):
    """All items come out right under each pair of stall patterns."""
    cases = _cases()
    await start(dut, cycles=_cycles(cases, len(STALL_PAIRS)))
    for number, given in enumerate(cases):
        for pair, (source_stalls, sink_stalls) in enumerate(STALL_PAIRS):
            bench = _Bench(dut, given, source_stalls, sink_stalls)
            if not pair:
                await bench.prepare()
                await RisingEdge(dut.clk)
            if not pair and not number:
                assert_known(dut, ["i", *bench.sinks])
            count = _stalled(given)
            await bench.source.send(given["items"][:count])
            await bench.finish(count)


@cocotb.test()
async def reset_in_flight(dut):
    """Nothing that was in flight comes out after a reset, and what comes then is right."""
    given, *_ = cases = _cases()
    await start(dut, cycles=_cycles(cases, 2))
    bench = _Bench(dut, given)
    await bench.prepare()
    items = given["items"]
    await bench.source.send(items[:min(len(items), 40) & ~3])
    for sink in bench.sinks.values():
        sink.stop()
    await reset(dut)
    bench = _Bench(dut, given)
    await bench.prepare()
    count = _stalled(given)
    await bench.source.send(items[:count])
    await bench.finish(count)


@cocotb.test()
async def one_item_per_interval(dut):
    """Without stalls items go in and out once per interval, after the latency."""
    cases = _cases()
    await start(dut, cycles=_cycles(cases, 1))
    for given in cases:
        bench, interval = _Bench(dut, given), given["interval"]
        await bench.prepare()
        taken = Monitor(dut, "i")
        await bench.source.send(given["items"])
        await bench.finish(len(given["items"]))
        taken.stop()
        assert {b - a for a, b in pairwise(taken.cycles)} == {interval}, "items must be taken without a gap"
        name, sink = list(bench.sinks.items())[-1]
        per_result = len(given["items"]) // len(given["expected"][name])
        assert {b - a for a, b in pairwise(sink.cycles)} == {interval * per_result}, f"{name} must come without a gap"
        assert sink.cycles[0] - taken.cycles[per_result - 1] == given["latency"]
