"""The exported engine at the pins of both ports, whose rules are checked: third-party models with all stalls, resets,
and faults of the bus.

Each fault is drawn by the seed and its number, both printed: ``SEED=1 FAULTS=17,21 pytest ...`` repeats two of them.
"""

import os
import random
from collections import Counter
from types import SimpleNamespace

import cocotb
import numpy as np
import pytest
from cocotb.triggers import ClockCycles, RisingEdge

from golden.engine.jobs.job import plan_job
from hw.registers.engine_registers import register
from hw.registers.error_code import ErrorCode
from radiosity.flow.host import POLL, EngineError, EngineTimeoutError, Host
from radiosity.flow.simulator.machine_verilog import cluster_verilog, top_verilog
from tb.axi.axi_protocol import AxiProtocol
from tb.axi.port_monitor import PortMonitor
from tb.lib.clocking import reset, start
from tb.lib.configurations import config_of
from tb.lib.runner import options, simulate
from tb.lib.seed import NIGHTS
from tb.lib.stall_patterns import STALLS
from tb.memsys.faulty_memory import READ_FAULTS, WRITE_FAULTS, BusFault, FaultyMemory
from tb.memsys.memory_bench import ModelAtPort
from tb.system.cocotb_port import CocotbPort
from tb.system.job_machine import SMALL
from tb.system.job_memory import JobMemory
from tb.system.scenes import phase

MODULE = "tb.system.test_engine_bus"
# Without a fault of the bus.
OWN = ("stop", "reset of the machine alone", "registers rewritten")
KINDS = (*READ_FAULTS, *WRITE_FAULTS, *OWN)
# Cycles that a load or a section may take, a resume, and those after which the machine hangs.
WATCHDOG, RESUME, TIMEOUT = 30_000, 10_000, 100_000
# Attempts until the machine has recovered: late replies are outstanding for three time-outs.
ATTEMPTS = 20
FAULTS = 30 * NIGHTS
# Numbers of the faults of each run. A fault that no burst of the job can have does not count: some more are drawn.
CHOSEN = [int(number) for number in os.environ.get("FAULTS", "").split(",") if number]
PARTS = [CHOSEN] if CHOSEN else [[*range(first, first + 55)] for first in range(0, FAULTS + FAULTS // 10, 55)]
# The memory of a third party begins at 0, ours beyond 2^32.
LOW, HIGH = 0x4000, 0x1_0000_4000


class Bench:
    """The engine, a memory that can be faulty, a host and a job. All other bytes of memory must not change."""

    def __init__(self, dut, *, base=HIGH, **memory):
        self.dut, self.seed = dut, options()["seed"]
        self.config = config_of(options()["changes"])
        self.job = plan_job([phase("cornell", self.config, cell=0.5, points=(5, 1), sets="scheduled")], self.config,
                            base=base)
        self.expected = JobMemory(self.job)
        self._memory = {"data": bytes(self.job.end - base), "base": base, "seed": self.seed, **memory}
        self.model = FaultyMemory(self.config, **self._memory)
        self._at_port = ModelAtPort(dut, self.model)
        self.port = CocotbPort(dut, self.model)
        self.host = Host(self.port, self.config)

    def stop(self):
        """No memory."""
        self._at_port.stop()

    async def restart(self):
        """Reset the machine, with an empty memory that has nothing outstanding and has seen no offer before."""
        self.stop()
        self.dut.rst.value = 1
        await ClockCycles(self.dut.clk, 2)
        self.model = self.port.memory = FaultyMemory(self.config, **self._memory)
        self._at_port = ModelAtPort(self.dut, self.model)
        self.dut.rst.value = 0

    async def _read(self):
        return await self.port.read_memory(self.job.base, self.job.end - self.job.base)

    async def begin(self):
        """The job's tables; all other bytes are the same. Returns main memory."""
        await self.port.write_memory(self.job.base, b"\xa5" * (self.job.end - self.job.base))
        await self.host.begin(self.job)
        await self.host.write("watchdog", WATCHDOG)
        return await self._read()

    async def check(self, before, records):
        """Of all descriptors: what has completed without an error is right."""
        found = codes(records)
        self.expected.check(before, await self._read(), np.array(records), base=self.job.base, errors=found)
        return found

    async def whole(self):
        """The codes of the descriptors of a job that end with an error."""
        before = await self.begin()
        return await self.check(before, await self.host.run(self.job, timeout=TIMEOUT))

    async def settled(self):
        """The queue has halted or has nothing to do."""
        for _ in range(TIMEOUT // POLL):
            status = await self.host.status()
            if not status["busy"]:
                break
            await self.port.wait(POLL)
        assert status["halted"] or not status["busy"], f"the machine hangs: {status}"

    async def ended(self):
        """The completion records until then."""
        await self.settled()
        return [*await self.host.collect(self.job)]

    async def resumes(self):
        """Whether a halted queue goes on."""
        try:
            await self.host.resume(self.job.phases[0].address, timeout=RESUME)
        except (EngineError, EngineTimeoutError):
            return False
        return True


def codes(records):
    """Error codes by tag."""
    return {int(one["tag"]): ErrorCode(int(one["error"])) for one in records if one["error"]}


@cocotb.test()
async def whole_job(dut):
    """A load and two frusta, twice."""
    bench = Bench(dut, latency=10, spread=6, shuffles=True)
    await start(dut, cycles=options()["cycles"])
    await bench.host.identify()
    for _ in range(2):
        assert not await bench.whole()


@cocotb.test()
async def third_parties(dut):
    """Registers and memory are both driven by others, cocotbext-axi's manager and RAM, with stalls."""
    from cocotbext.axi import AxiBus, AxiRam

    bench = Bench(dut, base=LOW)
    bench.stop()
    PortMonitor(dut, "axi", AxiProtocol(bench.config))
    ram = AxiRam(AxiBus.from_prefix(dut, "axi", bus_separator="__"), dut.clk, dut.rst, size=1 << 17)
    for half in ram.write_if, ram.read_if:
        half.log.setLevel("WARNING")
    bench.port.memory = SimpleNamespace(base=0, data=ram.mem)
    await start(dut, cycles=options()["cycles"])
    master, write, read = bench.port.master, ram.write_if, ram.read_if
    channels = (master.write_if.aw_channel, master.write_if.w_channel, master.write_if.b_channel,
                master.read_if.ar_channel, master.read_if.r_channel, write.aw_channel, write.w_channel,
                write.b_channel, read.ar_channel, read.r_channel)
    for number, regime in enumerate(STALLS):
        for k, channel in enumerate(channels):
            channel.set_pause_generator(STALLS[regime](10 * number + k))
        assert not await bench.whole()


@cocotb.test()
async def reset_in_flight(dut):
    """Machine and memory are reset together."""
    bench = Bench(dut, latency=8)
    await start(dut, cycles=options()["cycles"])
    for cycles in (50, 700, 1900, 3000, 5000):
        task = cocotb.start_soon(bench.whole())
        await ClockCycles(dut.clk, cycles)
        task.cancel()
        await bench.restart()
        assert not await bench.whole()


class Injection:
    """One fault in a job, and what follows.

    Parameters
    ----------
    bench
        The bench.
    size
        Bursts of reads and of writes, and cycles of a job.
    number
        Of the fault.
    """

    def __init__(self, bench, size, number):
        draw = random.Random(f"{bench.seed} {number}")
        self._bench, self._draw, self.kind = bench, draw, KINDS[number % len(KINDS)]
        bursts = size["writes" if self.kind in WRITE_FAULTS else "reads"]
        self._fault = BusFault(kind=self.kind, burst=draw.randrange(bursts), beat=draw.randrange(16))
        # A memory waits forever for the data of a write when only the machine is reset: that happens during the load.
        self._cycles = draw.randrange(1, size["cycles"] // (5 if self.kind == OWN[1] else 1))
        self.what = f"fault {number}: {self.kind}, burst {self._fault.burst}, beat {self._fault.beat}, or after " \
                    f"{self._cycles} cycles"

    async def _act(self):
        """A fault that is none of the bus."""
        bench, host = self._bench, self._bench.host
        await bench.port.wait(self._cycles)
        if self.kind == "stop":
            await host.command("stop")
        elif self.kind == "registers rewritten":
            for name in ("read_base", "read_limit", "write_base", "write_limit", "ring", "completions", "image"):
                ones = register(name).ones(bench.config.memory.address_bits)
                await host.write(name, self._draw.getrandbits(64) & ones)
        else:
            bench.model.faulty = True
            await reset(bench.dut)
            # Memory continues earlier reads.
            while bench.model.busy:
                await RisingEdge(bench.dut.clk)
            await ClockCycles(bench.dut.clk, 3)

    async def run(self):
        """How the first descriptor ended that did not end well, or what else happened; afterwards a job is right."""
        bench, host = self._bench, self._bench.host
        bench.model.arm(None)
        before = await bench.begin()
        if self.kind not in OWN:
            bench.model.arm(self._fault)
        await host.submit(bench.job, bench.job.descriptors)
        if self.kind in OWN:
            await self._act()
        outcome = await self._outcome(before)
        struck, lost = bench.model.struck or self.kind in OWN, bench.model.lost
        bench.model.arm(None)
        await self._recover(lost)
        return outcome if struck else "not struck"

    async def _outcome(self, before):
        bench, host = self._bench, self._bench.host
        if self.kind == OWN[1]:
            assert not any((await host.status()).values()), self.what
            return "reset"
        records = await bench.ended()
        halted = (await host.status())["halted"]
        if halted and bench.model.lost:
            return f"halted with {ErrorCode(await host.read('error')).name}"
        if halted:
            for _ in range(ATTEMPTS):
                if await bench.resumes():
                    break
            else:
                raise AssertionError(f"{self.what}: no resume in {ATTEMPTS} attempts")
            records += await bench.ended()
        found = await bench.check(before, records)
        assert self.kind != "registers rewritten" or not (found or halted), self.what
        return "halted" if halted else next(iter(found.values())).name if found else "right"

    async def _recover(self, lost):
        """A job is right in the end; after a burst that never ends, machine and memory are reset before."""
        bench, host = self._bench, self._bench.host
        for _ in range(2 if lost else ATTEMPTS):
            if (await host.status())["halted"] and not await bench.resumes():
                continue
            # A resumed queue takes what is left of the job before: its ring must not be written until then.
            await bench.settled()
            try:
                if await bench.whole():
                    continue
            except (EngineError, EngineTimeoutError):
                continue
            assert not lost, f"{self.what}: a burst that never ends was forgotten"
            return
        assert lost, f"{self.what}: no recovery in {ATTEMPTS} attempts"
        await bench.restart()
        assert not await bench.whole(), self.what


@cocotb.test()
async def injected_faults(dut):
    """Each ends what it concerns, in time; what completes without an error is right; the next job is right, or the one
    after a reset of machine and memory where a burst never ends; no byte beside the results changes.
    """
    bench = Bench(dut, latency=4, spread=8, shuffles=True)
    await start(dut, cycles=options()["cycles"])
    model, begin = bench.model, await bench.host.read("cycles")
    assert not await bench.whole()
    size = {"reads": len(model.reads), "writes": len(model.writes), "cycles": await bench.host.read("cycles") - begin}
    dut._log.info("a job: %s", size)
    found = Counter()
    for number in options()["faults"]:
        injection = Injection(bench, size, number)
        outcome = await injection.run()
        dut._log.info("SEED=%s, %s: %s", bench.seed, injection.what, outcome)
        found[injection.kind, outcome] += 1
    for (kind, outcome), times in sorted(found.items()):
        dut._log.info("%s: %s %d", kind, outcome, times)
    struck = sum(times for (_, outcome), times in found.items() if outcome != "not struck")
    assert struck >= options()["least"], f"{struck} faults have been injected"


def run(tests, **given):
    changes = SMALL | {"noc.columns": 2}
    config = config_of(changes)
    simulate(top_verilog(config) + cluster_verilog(config), MODULE, tests, changes=changes,
             visible=("clk", "rst", "host__*", "axi__*"), **{"cycles": 3_000_000} | given)


@pytest.mark.sim
def test_third_parties_and_resets():
    run(("whole_job", "third_parties", "reset_in_flight"))


@pytest.mark.nightly
@pytest.mark.parametrize("numbers", PARTS, ids=lambda numbers: f"from-{numbers[0]}")
def test_injected_faults(numbers):
    run(("injected_faults",), cycles=600_000 * len(numbers) + 10 ** 6, faults=numbers,
        least=0 if CHOSEN else FAULTS // len(PARTS))
