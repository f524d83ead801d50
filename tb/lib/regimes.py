"""The regimes of declared testbenches in cocotb: stall patterns, resets in drawn cycles, rate, latency, unknowns."""

import importlib
import random

import cocotb
from amaranth.lib.wiring import In, Out
from cocotb.triggers import ClockCycles

from tb.lib.clocking import start
from tb.lib.no_x import assert_known
from tb.lib.ports import Ports
from tb.lib.runner import options
from tb.lib.signature import payload_shape, stream_of, streams_of
from tb.lib.stall_patterns import STALLS, stall_pairs

__all__ = []

# Items of a case under each of many pairs of stall patterns: more of them find no further faults.
STALLED = 100
# Items of a case in simulators other than Verilator, which are slow.
FEW = 400
RESETS = 3


class _Run:
    """A declared testbench in the simulator."""

    def __init__(self, dut):
        module, name = getattr(dut, "bench", None) or options()["bench"]
        self.bench = getattr(importlib.import_module(module), name)()
        self.config = self.bench.config()
        self.component = self.bench.make(self.config)
        self.latency = self.bench.latency(self.component, self.config)
        signature = self.component.signature
        self.streams = streams_of(signature)
        self.bench.shapes = {name: payload_shape(signature, name) for name in self.streams[Out]}
        self.dut = dut

        self.cases = [case for case in self.bench.known_cases().values() if case.simulated]
        # Drawn vectors have predicted cycles if those of any case have.
        self.times_drawn = any(case.timed for case in self.cases)
        self.given = [self.enough(case.vectors(self.config)) for case in self.cases]

    def enough(self, given):
        """In slow simulators the first ones of many items."""
        if cocotb.SIM_NAME == "Verilator" or not self.bench.splits or len(given.inputs) > 1:
            return given
        (items,) = given.inputs.values()
        return given.part(0, FEW) if len(items) > FEW else given

    def drawn(self, number):
        """Fresh vectors."""
        return self.bench.drawn(self.config, 100 * options()["seed"] + number)

    @property
    def pairs(self):
        """Stall patterns of sources and sinks: the latter matter where an output can wait."""
        can_wait = any(not stream_of(self.component, name).signature.always_ready for name in self.streams[Out])
        if not can_wait:
            return [(name, "none") for name in STALLS]
        return stall_pairs()

    async def start(self, rounds):
        """Start the clock, with a watchdog of more cycles than all items can take."""
        items = sum(self.bench.interval * sum(map(len, given.inputs.values())) + self.latency for given in self.given)
        await start(self.dut, cycles=self.bench.cycles + rounds * (1000 + 6 * items))

    def ports(self, source="none", sink="none"):
        """All streams under a pair of patterns."""
        stalls = dict.fromkeys(self.streams[In], source) | dict.fromkeys(self.streams[Out], sink)
        ports = Ports(self.dut, self.component, stalls=stalls, intervals={"i": self.bench.interval})
        ports.respond(*self.bench.responders())
        return ports

    async def prepare(self, ports, given):
        """Values of ports, and what comes first."""
        self.bench.now = given
        for name, value in given.ports.items():
            ports[name] = value
        for name, items in given.first.items():
            stalls, ports.sources[name].stalls = ports.sources[name].stalls, iter(lambda: False, None)
            await ports.send(name, items)
            ports.sources[name].stalls = stalls
        await ClockCycles(self.dut.clk, 2)

    async def play(self, ports, given, timed):
        """Everything, compared; ``timed``: with the cycles of all transfers."""
        self.bench.now = given
        tasks = [ports.begin(name, items) for name, items in given.inputs.items()]
        came = {name: sink.items for name, sink in ports.sinks.items()}
        for task in tasks:
            await task
        while not self.bench.is_over(given, came):
            await ClockCycles(self.dut.clk, 8)
        await ClockCycles(self.dut.clk, self.latency + self.bench.idle_limit)
        self.bench.check(given, came)
        if timed:
            self.bench.check_cycles(given, ports.trace, self.component, self.config)
        for name, value in given.after.items():
            assert ports[name] == value, name


def _parts(given, count, splits):
    """As many parts of vectors as there are patterns, each of its own items if they are enough."""
    if not splits:
        return [given] * count
    (items,) = given.inputs.values()
    each = len(items) // count & ~3
    if each >= 16 or count == len(STALLS):
        ends = [each * (number + 1) for number in range(count - 1)] + [len(items)]
        return [given.part(begin, end) for begin, end in zip([0, *ends], ends, strict=False)]
    return [given.part(0, min(len(items) // 4, STALLED) & ~3)] * count


@cocotb.test()
async def stall_patterns(dut):
    """All items come out right under each pattern of stalls, and no signal is unknown after reset."""
    run = _Run(dut)
    pairs, draws, unknown = run.pairs, run.bench.draws, True
    await run.start(len(pairs))
    for case, given in [(None, None)] if draws else zip(run.cases, run.given, strict=True):
        parts = map(run.drawn, range(len(pairs))) if draws else _parts(given, len(pairs), run.bench.splits)
        for pair, part in zip(pairs, parts, strict=True):
            ports = run.ports(*pair)
            if draws or pair == pairs[0]:
                await run.prepare(ports, part)
            if unknown:
                assert_known(dut, [*ports.sources, *ports.sinks])
                unknown = False
            await run.play(ports, part, run.times_drawn if draws else case.timed)
            ports.stop()


@cocotb.test()
async def resets_in_flight(dut):
    """Nothing that was in flight comes out after a reset in a drawn cycle, and what comes then is right."""
    run = _Run(dut)
    await run.start(RESETS)
    generator, draws = random.Random(options()["seed"]), run.bench.draws
    given = run.drawn(0) if draws else run.given[0]
    # Few items in flight, the first ones at the output, and all that there can be.
    longest = min(len(next(iter(given.inputs.values()))), 40) * run.bench.interval
    for number, end in enumerate((max(2, run.latency), run.latency + longest // 2, run.latency + longest)):
        ports = run.ports()
        await run.prepare(ports, given)
        for name, items in given.inputs.items():
            ports.begin(name, items)
        await ClockCycles(dut.clk, generator.randint(1, end))
        await ports.reset()
        given = run.drawn(number) if draws else given
        await run.prepare(ports, given)
        part = given if draws else _parts(given, len(STALLS), run.bench.splits)[0]
        await run.play(ports, part, run.times_drawn if draws else run.cases[0].timed)
        ports.stop()


@cocotb.test()
async def rate(dut):
    """Without stalls all items of all cases come right, and in their cycles."""
    run = _Run(dut)
    await run.start(1)
    for case, given in zip(run.cases, run.given, strict=True):
        ports = run.ports()
        await run.prepare(ports, given)
        await run.play(ports, given, case.timed)
        ports.stop()
