"""The bench of a component with any number of streams: what goes in, and what must come out of each, in its order."""

from dataclasses import dataclass, field
from itertools import pairwise

import cocotb
from cocotb.triggers import ClockCycles, RisingEdge

from tb.lib.clocking import reset, start
from tb.lib.no_x import assert_known
from tb.lib.payload import pack
from tb.lib.runner import options, simulate
from tb.lib.stall_patterns import STALL_PAIRS, STALLS
from tb.lib.stream import Monitor, Sink, Source

__all__ = ["Streams", "check_streams"]

CASES = ("every_pair_of_stalls", "reset_in_flight", "one_per_cycle")


@dataclass(kw_only=True)
class Streams:
    """What a component is given and must give; by name of stream.

    Parameters
    ----------
    inputs, expected
        Payloads.
    first
        Streams and payloads that come one stream after the other, before anything else, and again after a reset.
    each_time
        Likewise before each run.
    ports, after
        Values of other inputs, and of other outputs when all is over.
    timing
        An input, an output and the cycles from the first item of one to the first of the other; both must pass one per
        cycle if nothing waits.
    """

    inputs: dict[str, list]
    expected: dict[str, list]
    first: list[tuple[str, list]] = field(default_factory=list)
    each_time: list[tuple[str, list]] = field(default_factory=list)
    ports: dict = field(default_factory=dict)
    after: dict = field(default_factory=dict)
    timing: tuple[tuple[str, str, int], ...] = ()


def check_streams(name: str, component, given: Streams, *, simulator: str) -> None:
    """All that is expected comes, whatever waits, also after a reset in flight; and one per cycle if nothing waits."""
    members = component.signature.members

    def packed(stream, items):
        shape = members[stream].signature.members["payload"].shape
        return [pack(shape, item) for item in items]

    simulate(component, __name__, CASES, simulator=simulator, name=f"{name}-{simulator}", given={
        "inputs": {stream: packed(stream, items) for stream, items in given.inputs.items()},
        "expected": {stream: packed(stream, items) for stream, items in given.expected.items()},
        "first": [(stream, packed(stream, items)) for stream, items in given.first],
        "each_time": [(stream, packed(stream, items)) for stream, items in given.each_time],
        "ports": {port: pack(members[port].shape, value) for port, value in given.ports.items()},
        "after": given.after, "timing": given.timing})


class _Bench:
    """The streams of a component for one run."""

    def __init__(self, dut, source="none", sink="none"):
        self.given, self.dut, seed = options()["given"], dut, options()["seed"]
        self.sources = {name: Source(dut, name, stalls=STALLS[source](seed + k))
                        for k, name in enumerate(self.given["inputs"])}
        self.sinks = {name: Sink(dut, name, stalls=STALLS[sink](seed + 10 + k))
                      for k, name in enumerate(self.given["expected"])}
        self.taken = {name: Monitor(dut, name) for name in self.given["inputs"]}
        self.tasks = []

    async def prepare(self):
        """Ports, and what comes once."""
        for port, value in self.given["ports"].items():
            getattr(self.dut, port).value = value
        for name, _ in (*self.given["first"], *self.given["each_time"]):
            Source(self.dut, name)
        for name, items in self.given["first"]:
            await Source(self.dut, name).send(items)
        await ClockCycles(self.dut.clk, 4)

    async def begin(self):
        for name, items in self.given["each_time"]:
            await Source(self.dut, name).send(items)
        self.tasks = [cocotb.start_soon(source.send(self.given["inputs"][name]))
                      for name, source in self.sources.items()]

    async def run(self):
        """Everything, compared."""
        await self.begin()
        expected = self.given["expected"]
        while any(len(sink.items) < len(expected[name]) for name, sink in self.sinks.items()):
            await RisingEdge(self.dut.clk)
        for task in self.tasks:
            await task
        await ClockCycles(self.dut.clk, 30)
        for name, sink in self.sinks.items():
            for number, (got, required) in enumerate(zip(sink.items, expected[name], strict=False)):
                assert got == required, f"{name}: item {number} is {got:#x}, not {required:#x}"
            assert len(sink.items) == len(expected[name]), f"{name}: {len(sink.items)} came"
        for port, value in self.given["after"].items():
            assert int(getattr(self.dut, port).value) == value, port

    def stop(self):
        for task in self.tasks:
            task.cancel()
        for monitor in (*self.sinks.values(), *self.taken.values()):
            monitor.stop()
        for source in self.sources.values():
            source.valid.value = 0


@cocotb.test()
async def every_pair_of_stalls(dut):
    """All comes out right under each pair of stall patterns."""
    await start(dut, cycles=400_000)
    prepared = False
    for source, sink in STALL_PAIRS:
        bench = _Bench(dut, source, sink)
        if not prepared:
            await bench.prepare()
            assert_known(dut, [*bench.sources, *bench.sinks])
            prepared = True
        await bench.run()
        bench.stop()


@cocotb.test()
async def reset_in_flight(dut):
    """Nothing that was in flight comes out after a reset, and what comes then is right."""
    await start(dut, cycles=100_000)
    bench = _Bench(dut)
    await bench.prepare()
    for wait in (3, 10, 24):
        await bench.begin()
        await ClockCycles(dut.clk, wait)
        bench.stop()
        await reset(dut)
        bench = _Bench(dut)
        await bench.prepare()
        assert not any(sink.items for sink in bench.sinks.values())
    await bench.run()


@cocotb.test()
async def one_per_cycle(dut):
    """Without stalls the streams whose timing is known do not stop, after the latency."""
    await start(dut, cycles=100_000)
    bench = _Bench(dut)
    await bench.prepare()
    await bench.run()
    for given, out, latency in bench.given["timing"]:
        entered, left = bench.taken[given].cycles, bench.sinks[out].cycles
        assert left[0] - entered[0] == latency, f"{out} comes after {left[0] - entered[0]} cycles, not {latency}"
        busiest = max((entered, left), key=len)
        assert {b - a for a, b in pairwise(busiest)} == {1}, f"{given} to {out} must be one per cycle"
