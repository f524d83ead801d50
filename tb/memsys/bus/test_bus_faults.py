"""The port of main memory after faults of the bus: all of memory is compared, and the next request follows at once."""

import random

import cocotb
import pytest
from cocotb.triggers import ClockCycles, RisingEdge

from hw.lib.payload import unpack
from hw.memsys.port.fault import Fault
from hw.memsys.port.main_memory_port import MainMemoryPort
from tb.lib.clocking import reset, start
from tb.lib.configurations import config_of
from tb.lib.drawn import drawn
from tb.lib.runner import options, simulate
from tb.lib.seed import NIGHTS
from tb.memsys.faulty_memory import READ_FAULTS, WRITE_FAULTS, BusFault, FaultyMemory
from tb.memsys.memory_bench import ModelAtPort
from tb.memsys.port.port_bench import BASE, READ, SMALL, TAG, WRITE, Bench, content

CHANGES = SMALL | {"memory.timeout_bits": 7}
KINDS = READ_FAULTS | WRITE_FAULTS
# Exchanges until the port has recovered, and cycles that one may take: four reads of 64 beats, two in a burst, one
# burst at a time, of at most 60 cycles.
EXCHANGES, TIMEOUT = 40, 4 * 32 * 60


class FaultBench:
    """Reads and writes at once, of parts that do not overlap, with errors or without.

    Members
    -------
    possible
        By address of a byte that may differ from ``model.data`` before: the values that it may have.
    """

    def __init__(self, dut, draw, **memory):
        self.dut, self.draw, self.bench = dut, draw, Bench(dut, sink=draw.choice(("none", "random")))
        self.bench.random = draw
        self.model = FaultyMemory(self.bench.config, content(), base=BASE, seed=draw.randrange(99), **memory)
        self.port, self.possible = ModelAtPort(dut, self.model), {}
        self._before = bytes(self.model.data)

    def stop(self):
        self.port.stop()
        self.bench.stop()

    async def exchange(self, count=4):
        """Whether no reply was an error. Replies without an error are right, and no other byte is written."""
        bench = self.bench
        for sink in (bench.replies, bench.written):
            sink.items.clear()
        reads, writes = ([bench.request(window, beats=self.draw.choice((None, 1, 3, 8))) for _ in range(count)]
                         for window in ((READ[0], WRITE[0]), WRITE))
        replies = [beat for one in reads for beat in bench.expected(one, self._before)]
        beats = bench.to_write(writes, bytearray(self._before))
        tasks = [bench.start(source, items) for source, items in (
            (bench.reads, reads), (bench.writes, writes), (bench.data, beats))]
        for _ in range(TIMEOUT):
            if len(bench.replies.items) >= len(replies) and len(bench.written.items) >= count:
                break
            await RisingEdge(self.dut.clk)
        else:
            raise AssertionError("an exchange hangs")
        for task in tasks:
            await task
        await ClockCycles(self.dut.clk, 2)
        assert not int(self.dut.busy.value)
        found, written = ([unpack(bench.shapes[sink.name], item) for item in sink.items]
                          for sink in (bench.replies, bench.written))
        for got, required in zip(found, replies, strict=True):
            assert (got["tag"], got["last"]) == (required["tag"], required["last"])
            assert got["error"] or got["data"] == required["data"], "a wrong beat without an error"
        assert [one["tag"] for one in written] == [one["tag"] for one in writes]
        self._compare(writes, written, beats)
        return not any(one["error"] for one in found + written)

    def _compare(self, writes, written, beats):
        """All bytes of memory."""
        beats, size = iter(beats), self.bench.bytes
        for request, answer in zip(writes, written, strict=True):
            for k in range(request["length"] + 1):
                beat = next(beats)
                for lane in range(size):
                    if beat["strobe"] >> lane & 1:
                        at, new = request["address"] - BASE + k * size + lane, beat["data"] >> 8 * lane & 255
                        known = {new} if not answer["error"] else {new, *self.possible.get(at, {self._before[at]})}
                        self.possible[at] = known
        data, expected = self.model.data, bytearray(self._before)
        for at, values in self.possible.items():
            assert data[at] in values, f"the byte at {BASE + at:#x} is {data[at]}, not one of {values}"
            expected[at] = data[at]
        assert data == expected, "a byte that was not written has changed"

    def fault(self):
        return self.bench.fault()[0]

    async def recovers(self):
        """Exchange until there is no error; then there is none in later exchanges."""
        for _ in range(EXCHANGES):
            if await self.exchange(2):
                break
        else:
            return False
        await self.bench.clear()
        for _ in range(2):
            assert await self.exchange(2), "an error after the port has recovered"
        assert self.fault() is Fault.NONE
        return True


async def restart(dut, bench, draw, **memory):
    """Machine and memory."""
    bench.stop()
    await reset(dut)
    return FaultBench(dut, draw, **memory)


@cocotb.test()
async def every_fault(dut):
    """Each fault is reported by its code; no wrong reply is accepted; the next exchange is right. If the burst never
    ends, all exchanges end with errors until a reset of machine and memory.
    """
    await start(dut, cycles=4_000_000)
    draw = random.Random(options()["seed"])
    memory = {"latency": 3, "spread": 6, "shuffles": True}
    bench = FaultBench(dut, draw, **memory)
    for round_ in range(options()["rounds"]):
        for kind, code in KINDS.items():
            if kind == "id of another read" and bench.bench.config.memory.outstanding == 1:
                continue
            fault = BusFault(kind=kind, burst=draw.randrange(5), beat=draw.randrange(8), error=draw.random() < 0.5)
            dut._log.info("round %d: %s", round_, fault)
            bench.model.arm(fault)
            clean = await bench.exchange()
            while not bench.model.struck:
                assert clean, "an error without a fault"
                clean = await bench.exchange()
            # An unexpected beat may come after the last reply.
            for _ in range(TIMEOUT):
                if bench.fault() is not Fault.NONE:
                    break
                await RisingEdge(dut.clk)
            assert bench.fault() is code, fault
            assert clean == (kind in ("unexpected beat", "last beat again", "unexpected answer", "answer again")), fault
            lost = bench.model.lost
            assert await bench.recovers() != lost, fault
            if lost:
                bench = await restart(dut, bench, draw, **memory)
                assert await bench.exchange()
    bench.stop()


@cocotb.test()
async def silent_channels(dut):
    """Whatever channel falls silent, all requests are answered; while late replies come, so are the next ones."""
    await start(dut, cycles=400_000)
    draw = random.Random(options()["seed"])
    for channel in ("ar", "r", "aw", "w", "b"):
        bench = FaultBench(dut, draw, latency=20, spread=20, shuffles=True)
        task = cocotb.start_soon(bench.exchange(8))
        await ClockCycles(dut.clk, draw.randrange(20, 90))
        bench.model.silent.add(channel)
        assert not await task, channel
        assert bench.fault() is (Fault.READ_TIMEOUT if channel in ("ar", "r") else Fault.WRITE_TIMEOUT)
        bench.model.silent.clear()
        assert await bench.recovers(), channel
        bench.stop()


@cocotb.test()
async def faults_beside_silence(dut):
    """A channel falls silent at a drawn distance from a fault: all requests are answered, errors have the code of one
    of the two, and the port recovers unless the burst never ends.
    """
    await start(dut, cycles=4_000_000)
    draw = random.Random(options()["seed"])
    for number in range(8 * options()["rounds"]):
        kind = draw.choice(sorted(READ_FAULTS if number % 2 else WRITE_FAULTS))
        if kind == "id of another read" and config_of(options()["changes"]).memory.outstanding == 1:
            continue
        bench = FaultBench(dut, draw, latency=5, spread=6, shuffles=True)
        fault = BusFault(kind=kind, burst=draw.randrange(4), beat=draw.randrange(8), error=draw.random() < 0.5)
        bench.model.arm(fault)
        task = cocotb.start_soon(bench.exchange(8))
        await ClockCycles(dut.clk, draw.randrange(8, 80))
        channel = draw.choice("rb")
        bench.model.silent.add(channel)
        clean = await task
        bench.model.silent.clear()
        codes, lost = {Fault.READ_TIMEOUT if channel == "r" else Fault.WRITE_TIMEOUT}, bench.model.lost
        if bench.model.struck:
            codes.add(KINDS[kind])
        bench.model.arm(None)
        dut._log.info("%s and silence of %s: %s", fault, channel, bench.fault())
        assert clean or bench.fault() in codes, fault
        assert await bench.recovers() != lost, fault
        bench.stop()
        if lost:
            await reset(dut)


@cocotb.test()
async def reset_of_the_machine_alone(dut):
    """Memory continues earlier reads: none of their beats is taken for one of a later read."""
    await start(dut, cycles=200_000)
    draw = random.Random(options()["seed"])
    for _ in range(6 * options()["rounds"]):
        bench = FaultBench(dut, draw, latency=draw.choice((2, 30)), spread=20, shuffles=True)
        requests = [bench.bench.request((READ[0], WRITE[0])) for _ in range(8)]
        bench.bench.start(bench.bench.reads, requests)
        await ClockCycles(dut.clk, draw.randrange(6, 120))
        bench.bench.stop()
        await reset(dut)
        outstanding, bench.model.faulty = bench.model.outstanding_reads, True
        while bench.model.busy:
            await RisingEdge(dut.clk)
        await ClockCycles(dut.clk, 3)
        # One beat may come in the last cycle of the reset.
        assert bench.fault() is Fault.READ_PROTOCOL or not outstanding
        bench.bench = Bench(dut)
        bench.bench.random = draw
        await bench.bench.clear()
        assert await bench.exchange()
        assert bench.fault() is Fault.NONE
        bench.stop()


@pytest.mark.sim
@pytest.mark.parametrize(("rounds", "changes"), [
    (1, {}), *(pytest.param(3 * NIGHTS, changes, marks=pytest.mark.nightly) for changes in drawn([
        {}, {"memory.data_bits": 512}, {"memory.outstanding": 1, "memory.burst_beats": 2}], 2))], ids=str)
def test_bus_faults(rounds, changes):
    changes = {**CHANGES, **changes}
    simulate(MainMemoryPort(config=config_of(changes), tag=TAG), __name__, changes=changes, rounds=rounds)
