"""The read engine's time-out; its bursts are tested at the port, `tb/memsys/test_main_memory_port.py`."""

from amaranth.sim import Simulator

from hw.memsys.fault import Fault
from hw.memsys.memory_formats import MemoryFormats
from hw.memsys.read_engine import ReadEngine
from tb.lib.configurations import config_of

CONFIG = config_of({"memory.timeout_bits": 4})
FIRST = 5, 9, 77


def test_a_time_out_has_the_address_of_the_oldest_burst():
    """Also when the last beat was of a later burst."""
    dut, faults = ReadEngine(config=CONFIG, tag=0), []

    async def bench(ctx):
        ctx.set(dut.o_address.ready, 1)
        for first in FIRST:
            ctx.set(dut.i.payload, {"first": first, "length": 0, "ends": 1, "bad": 0})
            ctx.set(dut.i.valid, 1)
            assert ctx.get(dut.i.ready)
            await ctx.tick()
        ctx.set(dut.i.valid, 0)
        await ctx.tick().repeat(2)
        ctx.set(dut.i_data.payload, {"id": 2, "data": 0, "response": 0, "last": 1})
        ctx.set(dut.i_data.valid, 1)
        await ctx.tick()
        ctx.set(dut.i_data.valid, 0)
        for _ in range(40):
            if ctx.get(dut.o_fault.valid):
                faults.append((Fault(ctx.get(dut.o_fault.payload.code)), ctx.get(dut.o_fault.payload.address)))
            await ctx.tick()

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    assert faults == [(Fault.READ_TIMEOUT, FIRST[0] << MemoryFormats(CONFIG).low_bits)]
