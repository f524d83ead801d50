"""The port at a memory that others wrote: cocotbext-axi's, with its own stalls, and one whose target raises."""

import random

import cocotb
import pytest
from cocotb.triggers import ClockCycles

from hw.memsys.fault import Fault
from hw.memsys.main_memory_port import MainMemoryPort
from tb.axi.axi_protocol import AxiProtocol
from tb.axi.port_monitor import PortMonitor
from tb.lib.clocking import reset, start
from tb.lib.configurations import config_of
from tb.lib.runner import SIMULATORS, options, simulate
from tb.lib.stall_patterns import STALLS, stall_pairs
from tb.memsys.test_main_memory_port import BASE, READ, SIZE, SMALL, TAG, WRITE, Bench, content

MODULE = "tb.memsys.test_third_party_memory"
# Its stalls are no silence.
CHANGES = {**SMALL, "memory.timeout_bits": 12}


class Regions:
    """Bytes at an address, as cocotbext-axi requests them from a target; some cannot be read."""

    def __init__(self, data, failed=lambda address: False, *, base=BASE):
        self.data, self._failed, self._base = bytearray(data), failed, base

    async def read(self, address, length):
        if self._failed(address):
            raise ValueError(f"nothing can be read at {address:#x}")
        return bytes(self.data[address - self._base:address - self._base + length])

    async def write(self, address, data):
        if self._failed(address):
            raise ValueError(f"nothing can be written at {address:#x}")
        at = address - self._base
        self.data[at:at + len(data)] = data


def attach(dut, target):
    """A subordinate with this target, where AXI's rules are checked, and the channels that can be stalled, by name."""
    from cocotbext.axi import AxiBus, AxiSlave

    PortMonitor(dut, "axi", AxiProtocol(config_of(options()["changes"])))
    slave = AxiSlave(AxiBus.from_prefix(dut, "axi", bus_separator="__"), dut.clk, dut.rst, target=target)
    write, read = slave.write_if, slave.read_if
    for side in (write, read):
        # A line for each burst takes longer than the burst.
        side.log.setLevel("WARNING")
    return {"aw": write.aw_channel, "w": write.w_channel, "b": write.b_channel, "ar": read.ar_channel,
            "r": read.r_channel}


def stall(channels, names, seed):
    for k, channel in enumerate(channels.values()):
        channel.set_pause_generator(STALLS[names[k % len(names)]](seed + k))


@cocotb.test()
async def every_pair_of_stalls(dut):
    """Requests of the clients against stalls of the memory."""
    await start(dut, cycles=200_000)
    ram = Regions(content())
    channels = attach(dut, ram)
    await reset(dut)
    for number, (clients, memory) in enumerate(stall_pairs()):
        bench = Bench(dut, clients, [*STALLS][number % 5])
        stall(channels, (memory, "random"), number)
        after = await bench.exchange(ram, 4)
        assert ram.data == after
        assert bench.fault()[0] is Fault.NONE
        bench.stop()


@cocotb.test()
async def a_target_that_raises(dut):
    """What cannot be read is an error, what can be is not."""
    await start(dut, cycles=60_000)
    bench = Bench(dut)

    def failed(address):
        return address // bench.bytes % 29 == 3

    channels = attach(dut, Regions(content(), failed))
    await reset(dut)
    stall(channels, ("none", "random"), bench.seed)
    # Of a word of which some bytes are written all of them fail: the target sees the first of these.
    before, requests = content(), [bench.request((READ[0], WRITE[0])) for _ in range(30)]
    task = bench.start(bench.reads, requests)
    replies = [beat for request in requests for beat in bench.expected(request, before, failed)]
    await bench.arrive(bench.replies, len(replies))
    await task
    bench.compare(bench.replies, replies)
    assert bench.fault()[0] is Fault.READ_REPLY
    await bench.clear()
    for at in (3, 4):
        address = WRITE[0] + (at - WRITE[0] // bench.bytes) % 29 * bench.bytes
        assert failed(address) == (at == 3)
        bench.written.items.clear()
        task = bench.start(bench.writes, [{"address": address, "length": 0, "tag": at}])
        await bench.send(bench.data, [{"data": 1, "strobe": (1 << bench.bytes) - 1}])
        await bench.arrive(bench.written, 1)
        await task
        bench.compare(bench.written, [{"tag": at, "error": at == 3}])
        assert bench.fault() == ((Fault.WRITE_REPLY, address) if at == 3 else (Fault.NONE, 0))
        await bench.clear()


@cocotb.test()
async def reset_in_flight(dut):
    """Machine and memory are reset together, in the middle of everything."""
    await start(dut, cycles=60_000)
    ram = Regions(content())
    channels = attach(dut, ram)
    generator = random.Random(options()["seed"])
    for _ in range(5):
        bench = Bench(dut, sink="random")
        stall(channels, ("random",), generator.randrange(100))
        task = cocotb.start_soon(bench.exchange(ram, 20))
        await ClockCycles(dut.clk, generator.randrange(10, 200))
        task.cancel()
        bench.stop()
        await reset(dut)
        bench = Bench(dut)
        assert await bench.exchange(ram, 2) == ram.data
        bench.stop()


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_third_party_memory(simulator):
    assert len(content()) == SIZE
    component = MainMemoryPort(config=config_of(CHANGES), tag=TAG)
    simulate(component, MODULE, ("every_pair_of_stalls", "a_target_that_raises", "reset_in_flight"),
             simulator=simulator, name=f"third_party_memory-{simulator}", changes=CHANGES)
