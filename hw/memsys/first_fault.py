"""First fault: what went wrong first is what one has to know."""

from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.memsys.fault import Fault
from hw.memsys.memory_formats import MemoryFormats

__all__ = ["FirstFault"]


class FirstFault(wiring.Component):
    """Keeps the first fault until it is cleared; of two in the same cycle that of the smaller number.

    Parameters
    ----------
    config
        The configuration.
    count
        Inputs, at least 1.

    Members
    -------
    i
        An array of faults. Always ready.
    clear
        Forget it.
    o
        The fault, all 0 while there is none.

    Timing
    ------
    Latency: ``1`` cycle.

    Errors
    ------
    ValueError
        Count out of range.
    """

    def __init__(self, *, config: Config, count: int):
        if not isinstance(count, int) or count < 1:
            raise ValueError(f"Count must be at least 1, not {count!r}")
        fault = MemoryFormats(config).fault
        super().__init__({"i": In(stream.Signature(fault, always_ready=True)).array(count), "clear": In(1),
                          "o": Out(fault)})
        self.latency = 1

    def elaborate(self, platform):
        m = Module()
        with m.If(self.clear):
            m.d.sync += self.o.as_value().eq(0)
        with m.Elif(self.o.code == Fault.NONE):
            for source in reversed(list(self.i)):
                with m.If(source.valid):
                    m.d.sync += self.o.eq(source.payload)
        return m
