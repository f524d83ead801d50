"""Block memory at a manager that others wrote: cocotbext-axi's."""

import random

import cocotb
import pytest
from cocotb.triggers import ClockCycles, RisingEdge

from hw.board.block_memory import DECERR, OKAY, BlockMemory
from radiosity.flow.synthesis.flow import synthesise
from tb.lib.clocking import reset, start
from tb.lib.configurations import config_of
from tb.lib.no_x import assert_known
from tb.lib.runner import SIMULATORS, options, simulate
from tb.lib.stall_patterns import STALL_PAIRS, STALLS
from tb.lib.stream import Monitor, Sink, Source
from tb.lib.timing import documented_latency

# No multiple of a beat, and no power of two.
SIZE = 2500
WIDTHS = {bits: {"memory.data_bits": bits, "memory.address_bits": 16} for bits in (64, 128, 512)}


def content():
    return random.Random(5).randbytes(SIZE)


class Bench:
    """A manager, a reader that peeks, and what memory must hold."""

    def __init__(self, dut):
        from cocotbext.axi import AxiBus, AxiMaster

        self.dut, self.random = dut, random.Random(options()["seed"])
        self.bytes = options()["data_bits"] // 8
        self.data = bytearray(content() + bytes(-SIZE % self.bytes))
        self.master = AxiMaster(AxiBus.from_prefix(dut, "axi", bus_separator="__"), dut.clk, dut.rst)
        for side in self.master.write_if, self.master.read_if:
            side.log.setLevel("WARNING")
        self.channels = {name: getattr(side, f"{name}_channel") for side, names in (
            (self.master.write_if, ("aw", "w", "b")), (self.master.read_if, ("ar", "r"))) for name in names}
        self.peeks = Source(dut, "i_peek")
        self.peeked = Sink(dut, "o_peek")

    async def fill(self):
        """What tests before have left is no longer there."""
        await self.write(0, bytes(self.data))

    def stall(self, give, take):
        for k, (name, channel) in enumerate(self.channels.items()):
            channel.set_pause_generator(STALLS[take if name in "br" else give](self.random.randrange(1 << 20) + k))

    def part(self, limit):
        """Address and size of some bytes."""
        size = self.random.randint(1, min(60 * self.bytes, limit // 2))
        return self.random.randrange(limit - size), size

    async def write(self, address, data):
        reply = await self.master.write(address, data)
        assert int(reply.resp) == OKAY
        self.data[address:address + len(data)] = data

    async def read(self, address, size):
        reply = await self.master.read(address, size)
        assert int(reply.resp) == OKAY
        assert reply.data == self.data[address:address + size], hex(address)

    async def compare(self, beats):
        """Peek at beats."""
        self.peeked.items.clear()
        await self.peeks.send(beats)
        while len(self.peeked.items) < len(beats):
            await RisingEdge(self.dut.clk)
        assert self.peeked.items == [
            int.from_bytes(self.data[beat * self.bytes:][:self.bytes], "little") for beat in beats]


@cocotb.test()
async def every_pair_of_stalls(dut):
    """Writes and reads of each other's halves at once; both of everything."""
    await start(dut, cycles=200_000)
    bench, half = Bench(dut), SIZE // 2
    await RisingEdge(dut.clk)
    assert_known(dut, ("i_peek", "o_peek"))
    assert all(getattr(dut, f"axi__{name}").value.is_resolvable for name in ("arready", "awready", "rvalid", "bvalid"))
    for give, take in STALL_PAIRS:
        bench.stall(give, take)
        bench.peeked.stalls = STALLS[take](3)
        (address, size), (first, count) = bench.part(half), bench.part(half)
        task = cocotb.start_soon(bench.write(address, bench.random.randbytes(size)))
        await bench.read(half + first, count)
        await task
        await bench.read(address, size)
        await bench.compare([bench.random.randrange(len(bench.data) // bench.bytes) for _ in range(5)])
    await bench.compare(range(len(bench.data) // bench.bytes))


@cocotb.test()
async def peeks_beside_reads(dut):
    """Who peeks waits for bursts, and neither gets the other's beats."""
    await start(dut, cycles=50_000)
    bench = Bench(dut)
    await bench.fill()
    bench.stall("random", "random")
    bench.peeked.stalls = STALLS["random"](4)
    for _ in range(6):
        task = cocotb.start_soon(bench.read(*bench.part(SIZE)))
        await bench.compare([bench.random.randrange(SIZE // bench.bytes) for _ in range(20)])
        await task


@cocotb.test()
async def beats_beyond_the_end(dut):
    """Are errors, and change nothing."""
    await start(dut, cycles=50_000)
    bench = Bench(dut)
    await bench.fill()
    end = len(bench.data)
    for address, size in ((end, 8), (end - bench.bytes, 3 * bench.bytes), (4096, 64), ((1 << 16) - 64, 64)):
        assert int((await bench.master.read(address, size)).resp) == DECERR
        assert int((await bench.master.write(address, bytes(range(1, size + 1)))).resp) == DECERR
        inside = max(0, end - address)
        bench.data[address:address + inside] = bytes(range(1, size + 1))[:inside]
        await bench.read(end - bench.bytes, bench.bytes)
    await bench.compare(range(len(bench.data) // bench.bytes))


@cocotb.test()
async def one_beat_per_cycle(dut):
    """The latency that is documented, and no gaps in a burst."""
    await start(dut, cycles=20_000)
    bench, beats = Bench(dut), []
    await bench.fill()
    requests, came = (Monitor(dut, name) for name in ("i_peek", "o_peek"))
    await bench.compare(range(20))
    assert came.cycles[0] - requests.cycles[0] == 1

    async def watch():
        cycle = 0
        while True:
            await RisingEdge(dut.clk)
            cycle += 1
            if int(dut.axi__arvalid.value) and int(dut.axi__arready.value):
                beats.append(cycle)
            if int(dut.axi__rvalid.value) and int(dut.axi__rready.value):
                beats.append(cycle)

    task = cocotb.start_soon(watch())
    await bench.read(0, 32 * bench.bytes)
    task.cancel()
    assert [beat - beats[0] for beat in beats[1:]] == list(range(options()["latency"], 32 + options()["latency"]))


@cocotb.test()
async def reset_in_flight(dut):
    """Nothing of a burst comes after a reset."""
    await start(dut, cycles=20_000)
    bench = Bench(dut)
    await bench.fill()
    for cycles in (3, 11, 20):
        bench.master.init_read(0, 40 * bench.bytes)
        bench.master.init_write(0, bytes(bench.data[:40 * bench.bytes]))
        await ClockCycles(dut.clk, cycles)
        await reset(dut)
        await ClockCycles(dut.clk, 3)
        await bench.read(*bench.part(SIZE))


@pytest.mark.parametrize("data_bits", [64, *(pytest.param(bits, marks=pytest.mark.nightly) for bits in (128, 512))])
@pytest.mark.parametrize("simulator", SIMULATORS)
def test_block_memory(simulator, data_bits):
    config = config_of(WIDTHS[data_bits])
    component = BlockMemory(config=config, data=content())
    assert component.latency == documented_latency(BlockMemory, config)
    simulate(component, __name__, simulator=simulator, data_bits=data_bits, latency=component.latency)


@pytest.mark.parametrize("size", [0, (1 << 16) + 1])
def test_sizes(size):
    with pytest.raises(ValueError, match=rf"Data must be 1 to 65536 bytes \(memory.address_bits\), not {size}"):
        BlockMemory(config=config_of(WIDTHS[64]), data=bytes(size))


def test_bytes_lie_in_block_ram(tmp_path):
    # Four blocks of 18 bits side by side, of which each has 1024 words.
    area = synthesise(BlockMemory(config=config_of(WIDTHS[64]), data=bytes([1]) * 8192), tmp_path)
    assert area.bram == 4
    assert area.lut < 400
