"""Whole frusta on the whole machine after faults of the bus, stops, resets and windows rewritten while used.

Each fault is drawn by the seed and its number, both printed: ``SEED=1 FAULTS=17,21 pytest ...`` repeats two of them.
"""

import os
import random
from collections import Counter

import cocotb
import pytest
from cocotb.triggers import ClockCycles, RisingEdge

from golden.memory_map import from_bytes
from hw.control.load_control import ALL as ALL_REGIONS
from hw.host import EngineError
from hw.simulator.machine_verilog import engine_verilog
from tb.lib.clocking import reset, start
from tb.lib.configurations import config_of
from tb.lib.runner import BUILD, options, simulate
from tb.memsys.faulty_memory import READ_FAULTS, WRITE_FAULTS, BusFault, FaultyMemory
from tb.memsys.memory_bench import ModelAtPort
from tb.system.scenes import frusta, save
from tb.system.test_engine import BASE, SMALL, Bench

MODULE = "tb.memsys.test_engine_bus_faults"
CHANGES = SMALL | {"noc.columns": 2}
# Without a fault of the bus.
OWN = ("stop", "reset of the machine alone", "windows rewritten")
KINDS = (*READ_FAULTS, *WRITE_FAULTS, *OWN)
PHASES = {"load": "loads", "cast": "casts", "write": "writes"}
# Cycles that a command may take, and those after which the host reports that it hangs.
WATCHDOG, TIMEOUT = 30_000, 60_000
# Attempts until the machine has recovered: late replies are outstanding for three time-outs.
ATTEMPTS = 20
FAULTS = 300


class FaultBench(Bench):
    """The engine at a memory that can be faulty, twice as large as an image."""

    def __init__(self, dut, **memory):
        super().__init__(dut, images=2, **memory)
        self._guard = random.Random(1).randbytes(self.image_bytes)
        self.restart()

    def restart(self):
        """An empty memory with nothing outstanding; all that lies behind the image is random."""
        self.stop()
        self.model = self.port.memory = FaultyMemory(self.config, **self._memory)
        self.model.data[self.image_bytes:] = self._guard
        self._at_port = ModelAtPort(self.dut, self.model)

    async def windows(self, frustum, *, wrong=None):
        """Write all windows, or random ones, in two halves each."""
        base, end = BASE, BASE + len(frustum.image.to_bytes())
        for name, value in (("read_base", base), ("read_limit", end), ("write_base", base + frustum.image.offsets[
                "hits"]), ("write_limit", end)):
            await self.host.write(name, value if wrong is None else wrong.getrandbits(64))

    async def frustum(self, frustum, action=None):
        """Load, cast, and write results; an action occurs in each of these phases.

        Raises
        ------
        EngineError
            One of them has ended with an error.
        """
        host, image = self.host, frustum.image
        data = image.to_bytes()
        await host.write("watchdog", WATCHDOG)
        try:
            await host.load(image, lives=(), timeout=TIMEOUT)
            for name, value in (("regions", ALL_REGIONS), ("total", frustum.total), ("results", 3)):
                await host.write(name, value)
            for phase, busy in PHASES.items():
                await self.windows(frustum)
                await host.command(phase)
                if action:
                    await action(phase)
                await host.finish(busy, timeout=TIMEOUT)
        finally:
            # Whatever has happened, the rest of memory is as before.
            first, found = image.offsets["hits"], self.model.data
            assert found[:first] == data[:first], "a byte in front of the window has changed"
            assert found[len(data):] == bytes(self.image_bytes - len(data)) + self._guard, (
                "a byte behind it has changed")

    def right(self, frustum):
        """The results in memory are golden's."""
        self.compare(from_bytes(bytes(self.model.data[:len(frustum.image.to_bytes())])), frustum)

    async def restarted(self):
        """Machine and memory."""
        self.restart()
        await reset(self.dut)


class Injection:
    """One fault in a frustum, and what follows."""

    def __init__(self, bench, bursts, number):
        draw = random.Random(f"{bench.given['seed']} {number}")
        self._bench, self._draw, self.kind = bench, draw, KINDS[number % len(KINDS)]
        phases = ("write",) if self.kind in WRITE_FAULTS else ("load", "cast") if self.kind in (
            *READ_FAULTS, OWN[1]) else tuple(PHASES)
        self.phase = draw.choice(phases)
        self._fault = BusFault(kind=self.kind, burst=draw.randrange(bursts[self.phase]), beat=draw.randrange(16))
        self._cycles = draw.randrange(1, {"load": 1500, "cast": 3000, "write": 400}[self.phase])
        self.what = f"fault {number}: {self.kind} in a {self.phase}, burst {self._fault.burst}, beat " \
                    f"{self._fault.beat}, or after {self._cycles} cycles"

    async def act(self, phase):
        """In the phase."""
        bench = self._bench
        if phase != self.phase:
            return
        if self.kind not in OWN:
            bench.model.arm(self._fault)
            return
        await bench.port.wait(self._cycles)
        if self.kind == "stop":
            await bench.host.stop(timeout=TIMEOUT)
        elif self.kind == "windows rewritten":
            await bench.windows(bench.frusta[0], wrong=self._draw)
        else:
            bench.model.faulty = True
            await reset(bench.dut)
            # Memory continues earlier reads.
            while bench.model.busy:
                await RisingEdge(bench.dut.clk)
            await ClockCycles(bench.dut.clk, 3)

    async def run(self):
        """The outcome of the frustum with the fault, if it has occurred; afterwards a frustum is right."""
        bench, frustum = self._bench, self._bench.frusta[0]
        bench.model.arm(None)
        try:
            await bench.frustum(frustum, self.act)
            outcome = "stopped" if self.kind in OWN[:2] else "reported later" if (
                await bench.host.status())["failed"] else "right"
        except EngineError as error:
            outcome = error.code.name
        assert outcome == "right" or self.kind != "windows rewritten", self.what
        if outcome == "right":
            bench.right(frustum)
        struck, lost = bench.model.struck or self.kind in OWN, bench.model.lost
        bench.model.arm(None)
        for _ in range(2 if lost else ATTEMPTS):
            try:
                await bench.frustum(frustum)
            except EngineError:
                continue
            assert not lost, f"{self.what}: a burst that never ends was forgotten"
            break
        else:
            assert lost, f"{self.what}: no recovery in {ATTEMPTS} attempts"
            await bench.restarted()
            await bench.frustum(frustum)
        bench.right(frustum)
        return outcome if struck else "not struck"


@cocotb.test()
async def injected_faults(dut):
    """Each ends in time with an error or without harm; the next frustum is right, or the one after a reset of machine
    and memory where a burst never ends; no byte outside the window changes.
    """
    bench = FaultBench(dut, latency=4, spread=8, shuffles=True)
    await start(dut, cycles=options()["cycles"])
    await bench.host.identify()
    before, model = {}, bench.model

    async def count(phase):
        before[phase] = len(model.reads)

    await bench.frustum(bench.frusta[0], count)
    bench.right(bench.frusta[0])
    bursts = {"load": before["cast"] - before["load"], "cast": len(model.reads) - before["cast"],
              "write": len(model.writes)}
    dut._log.info("bursts of a frustum: %s", bursts)
    found = Counter()
    for number in options()["faults"]:
        injection = Injection(bench, bursts, number)
        outcome = await injection.run()
        dut._log.info("SEED=%s, %s: %s", bench.given["seed"], injection.what, outcome)
        found[injection.kind, outcome] += 1
    for (kind, outcome), times in sorted(found.items()):
        dut._log.info("%s: %s %d", kind, outcome, times)
    struck = sum(times for (_, outcome), times in found.items() if outcome != "not struck")
    assert struck >= options()["least"], f"{struck} faults have been injected"


def run(numbers, least):
    config = config_of(CHANGES)
    folder = save(frusta("cornell", config, cell=0.5, points=(5,)), BUILD / "vectors" / "engine-bus-faults")
    simulate(engine_verilog(config), MODULE, ("injected_faults",), name="engine-bus-faults", changes=CHANGES,
             visible=("clk", "rst", "host__*", "axi__*"), folder=str(folder), cycles=400_000 * len(numbers) + 10 ** 6,
             faults=numbers, least=least)


@pytest.mark.nightly
def test_injected_faults():
    chosen = os.environ.get("FAULTS")
    # A fault that no burst of the frustum can have does not count: some more are drawn.
    numbers = [int(number) for number in chosen.split(",")] if chosen else list(range(FAULTS + FAULTS // 10))
    run(numbers, 0 if chosen else FAULTS)
