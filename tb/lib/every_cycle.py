"""The table of a declared testbench with a model, in cocotb."""

import importlib

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import RisingEdge

from tb.lib.clocking import PERIOD
from tb.lib.cycles import Table
from tb.lib.runner import options

__all__ = []


@cocotb.test()
async def every_cycle(dut):
    """All outputs are the model's in each cycle."""
    module, name = getattr(dut, "bench", None) or options()["bench"]
    bench = getattr(importlib.import_module(module), name)()
    config = bench.config()
    table = Table(bench, bench.make(config), config, options()["seed"])
    before, edge = {}, RisingEdge(dut.clk)
    Clock(dut.clk, PERIOD, unit="ns").start()
    # A payload without bits is no signal in Verilog.
    handles = {name: handle for name in (*table.inputs, *table.outputs)
               if (handle := getattr(dut, name, None)) is not None}
    for number, cycle in enumerate(table.cycles):
        dut.rst.value = int(cycle.resets)
        for name, value in cycle.given.items():
            if name in handles and before.get(name) != value:
                handles[name].value = value
        before = cycle.given
        await edge
        for name, (_, mask) in cycle.expected.items():
            if mask:
                value = handles[name].value
                # What is not compared may be unknown: 0 or 1.
                for came in [int(value)] if value.is_resolvable else [
                        int(str(value).upper().replace("X", bit).replace("Z", bit), 2) for bit in "01"]:
                    table.compare(number, name, came)
