"""Clock, reset and watchdog of a testbench."""

import cocotb
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, RisingEdge

__all__ = ["PERIOD", "Watchdog", "reset", "start"]

# Nanoseconds of a cycle.
PERIOD = 10


async def start(dut, *, cycles: int) -> None:
    """Start the clock, reset the component, and end the test if it takes more than ``cycles`` cycles."""
    Clock(dut.clk, PERIOD, unit="ns").start()
    Watchdog(dut, cycles)
    await reset(dut)


async def reset(dut) -> None:
    """Two cycles of reset."""
    dut.rst.value = 1
    await ClockCycles(dut.clk, 2)
    dut.rst.value = 0


class Watchdog:
    """Fails the test after a number of cycles, so that a deadlock is reported.

    Parameters
    ----------
    cycles
        Counted from now on.
    """

    def __init__(self, dut, cycles: int):
        self._dut, self._cycles = dut, cycles
        cocotb.start_soon(self._expire())

    async def _expire(self):
        await ClockCycles(self._dut.clk, self._cycles)
        await RisingEdge(self._dut.clk)
        raise AssertionError(f"the watchdog waited {self._cycles} cycles for the testbench to end")
