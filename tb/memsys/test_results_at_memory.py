"""Results of two clusters in main memory: writers, their merge, and the port."""

from random import Random

import cocotb
import pytest
from amaranth.hdl import Module
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out
from cocotb.triggers import ClockCycles, RisingEdge

from golden.ctu.sector import Sector
from golden.jobs.result_formats import HitFormat
from hw.memsys.axi_signature import AxiSignature
from hw.memsys.fault import Fault
from hw.memsys.main_memory_port import MainMemoryPort
from hw.memsys.memory_formats import MemoryFormats
from hw.memsys.result_writer import ResultWriter
from hw.memsys.write_merge import WriteMerge
from tb.lib.clocking import reset, start
from tb.lib.configurations import config_of
from tb.lib.no_x import assert_known
from tb.lib.ports import Ports
from tb.lib.runner import SIMULATORS, options, simulate
from tb.lib.stall_patterns import stall_pairs
from tb.memsys.faulty_memory import WRITE_FAULTS, BusFault, FaultyMemory
from tb.memsys.memory_bench import ModelAtPort
from tb.memsys.section_results import drawn_section, joined

COUNT = 2
SMALL = {"memory.outstanding": 4, "memory.burst_beats": 8, "memory.length_bits": 4, "memory.timeout_bits": 10}
BASE, SIZE = 0x3_0000_2000, 1 << 15
STREAMS = ("i", "i_hit", "i_sum")
# Until late answers have come.
ATTEMPTS = 40


class Results(wiring.Component):
    """The writers at the port."""

    def __init__(self, *, config):
        self.port, self.merge = MainMemoryPort(config=config, tag=range(COUNT)), WriteMerge(config=config, count=COUNT)
        self.writers = [ResultWriter(config=config) for _ in range(COUNT)]
        members = self.writers[0].signature.members
        super().__init__({**{f"{name}_{k}": members[name] for k in range(COUNT) for name in (*STREAMS, "o_done")},
                          "axi": Out(AxiSignature(config=config)), "window": In(MemoryFormats(config).window)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.port, m.submodules.merge = port, merge = self.port, self.merge
        for k, writer in enumerate(self.writers):
            m.submodules[f"writer_{k}"] = writer
            for name in STREAMS:
                wiring.connect(m, wiring.flipped(getattr(self, f"{name}_{k}")), getattr(writer, name))
            wiring.connect(m, writer.o_done, wiring.flipped(getattr(self, f"o_done_{k}")))
            wiring.connect(m, writer.o_request, merge.i_request[k])
            wiring.connect(m, writer.o_data, merge.i_data[k])
            wiring.connect(m, merge.o_written[k], writer.i_written)
        wiring.connect(m, merge.o_request, port.i_write)
        wiring.connect(m, merge.o_data, port.i_write_data)
        wiring.connect(m, port.o_written, merge.i_written)
        wiring.connect(m, port.axi, wiring.flipped(self.axi))
        m.d.comb += port.write_window.eq(self.window)
        return m


class Bench:
    """Two clusters, and a memory whose bytes are random."""

    def __init__(self, dut, *, source="none", memory="none", limit=BASE + SIZE, **given):
        self.config = config_of(options()["changes"])
        self.ports = Ports(dut, Results(config=self.config),
                           stalls={f"{name}_{k}": source for name in STREAMS for k in range(COUNT)})
        self.ports["window"] = {"base": BASE, "limit": limit}
        self.before = Random(options()["seed"]).randbytes(SIZE)
        self.memory = FaultyMemory(self.config, self.before, base=BASE, seed=options()["seed"],
                                   stalls={"aw": memory, "w": memory, "b": "random"}, **given)
        self.port = ModelAtPort(dut, self.memory)

    def sections(self, seed, count, **given):
        """Some sections for each cluster, each in bytes of its own."""
        return [[drawn_section(seed + 10 * number + k, self.config, **{
            "hits": BASE + 4096 * (2 * number + k), "sums_address": BASE + 4096 * (2 * number + k) + 3584, **given})
            for number in range(count)] for k in range(COUNT)]

    async def write(self, sections):
        """The faults with which the sections of each cluster end."""
        sinks = [self.ports.sinks[f"o_done_{k}"].items for k in range(COUNT)]
        before = list(map(len, sinks))
        for k, mine in enumerate(sections):
            for name, items in joined(mine).items():
                self.ports.begin(f"{name}_{k}", items)
        await self.ports.until(lambda: all(len(items) >= first + len(mine) for items, first, mine in zip(
            sinks, before, sections, strict=True)))
        return [[(Fault(one["code"]), one["sums"]) for one in self.ports.came(f"o_done_{k}", first)]
                for k, first in enumerate(before)]

    def compare(self, sections, *, or_before=False):
        """Byte by byte; ``or_before``: where something has gone wrong, a byte may be as it was."""
        right = dict(enumerate(self.before, start=BASE))
        right |= {address: byte for mine in sections for one in mine for address, byte in one.memory.items()}
        different = [address for address, byte in enumerate(self.memory.data, start=BASE) if byte != right[address]
                     and not (or_before and byte == self.before[address - BASE])]
        assert not different, f"{len(different)} bytes are others, the first one at {different[0]:#x}"

    def stop(self):
        self.port.stop()
        self.ports.stop()


def without_fault(sections):
    """What ends the sections."""
    return [[(Fault.NONE, len(one.sums) * one.command.sums) for one in mine] for mine in sections]


@cocotb.test()
async def every_pair_of_stalls(dut):
    """Of what gives the results and of the memory."""
    await start(dut, cycles=200_000)
    for number, (source, memory) in enumerate(stall_pairs()):
        bench = Bench(dut, source=source, memory=memory, latency=3, spread=9)
        if not number:
            await RisingEdge(dut.clk)
            assert_known(dut, [*bench.ports.sources, *bench.ports.sinks])
        sections = bench.sections(100 * number + options()["seed"], 2)
        assert await bench.write(sections) == without_fault(sections)
        bench.compare(sections)
        bench.stop()


@cocotb.test()
async def faults_of_the_bus(dut):
    """Results that memory answers wrongly end with a fault, or are right; so are the next ones, at once.

    After an answer that never comes a reset is necessary.
    """
    await start(dut, cycles=300_000)
    draw, bench = Random(options()["seed"]), Bench(dut, latency=4, spread=5)
    given = {"columns": 20, "section": Sector(1, 13, 0, 6), "hit_format": HitFormat.FULL}
    for kind in WRITE_FAULTS:
        bench.memory.data[:], sections = bench.before, bench.sections(draw.randrange(1 << 20), 1, **given)
        # Only the first burst is alone.
        burst = 0 if kind == "answer before the data" else draw.randrange(5)
        bench.memory.arm(BusFault(kind=kind, burst=burst, beat=0))
        codes = [mine[0][0] for mine in await bench.write(sections)]
        assert bench.memory.struck, kind
        assert set(codes) <= {Fault.NONE, Fault.WRITE_REPLY}, kind
        assert kind in ("unexpected answer", "answer again") or Fault.WRITE_REPLY in codes, kind
        bench.compare(sections, or_before=True)
        # What will never end is known to the memory alone.
        for _ in range(3 if bench.memory.lost else ATTEMPTS):
            if await bench.write(sections) == without_fault(sections):
                break
            bench.compare(sections, or_before=True)
        else:
            assert bench.memory.lost, kind
            bench.stop()
            await reset(dut)
            bench = Bench(dut, latency=4, spread=5)
            assert await bench.write(sections) == without_fault(sections)
        bench.compare(sections)
    bench.stop()


@cocotb.test()
async def results_outside_the_window(dut):
    """End with a fault; those of the other cluster do not, and nothing is written outside."""
    await start(dut, cycles=40_000)
    bench = Bench(dut, limit=BASE + 4096)
    sections = bench.sections(3, 1, columns=20, section=Sector(1, 13, 0, 6), hit_format=HitFormat.COMPACT, sums=True)
    codes = await bench.write(sections)
    assert codes == [without_fault(sections)[0], [(Fault.WRITE_REPLY, 0)]]
    bench.compare(sections[:1])
    bench.stop()


@cocotb.test()
async def reset_in_flight(dut):
    """Nothing of the sections before is written after a reset, and the next ones are right."""
    await start(dut, cycles=60_000)
    draw = Random(options()["seed"])
    for _ in range(6):
        bench = Bench(dut, latency=9)
        for k, mine in enumerate(bench.sections(draw.randrange(1 << 20), 3)):
            for name, items in joined(mine).items():
                bench.ports.begin(f"{name}_{k}", items)
        await ClockCycles(dut.clk, draw.randint(5, 150))
        bench.port.stop()
        await bench.ports.reset()
        bench.stop()
        bench = Bench(dut, latency=9)
        sections = bench.sections(draw.randrange(1 << 20), 2)
        assert await bench.write(sections) == without_fault(sections)
        bench.compare(sections)
        bench.stop()


@cocotb.test()
async def a_beat_per_cycle(dut):
    """Two writers of hits of 16 bytes send a beat in every cycle from the first one to the last one, or take a hit
    each in every cycle where these are fewer than the beats.
    """
    await start(dut, cycles=20_000)
    bench, cycles, now = Bench(dut), [], 0
    sections = bench.sections(3, 1, columns=16, section=Sector(0, 16, 0, 8), hit_format=HitFormat.FULL, sums=False)

    async def watch():
        nonlocal now
        while True:
            await RisingEdge(dut.clk)
            now += 1
            if int(dut.axi__wvalid.value) and int(dut.axi__wready.value):
                cycles.append(now)

    bench.ports.run(watch())
    assert await bench.write(sections) == without_fault(sections)
    hits = 16 * 8
    beats = 2 * hits * 16 // bench.config.memory.beat_bytes
    assert len(cycles) == beats
    assert cycles[-1] - cycles[0] < max(beats, hits)
    bench.compare(sections)
    bench.stop()


def run(simulator, changes):
    changes = {**SMALL, **changes}
    simulate(Results(config=config_of(changes)), __name__, simulator=simulator, changes=changes)


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_results(simulator):
    run(simulator, {})


@pytest.mark.icarus
@pytest.mark.nightly
@pytest.mark.parametrize("bits", [128, 256, 512])
def test_wide_beats(bits):
    run("icarus", {"memory.data_bits": bits})
