"""First fault: the first of several faults, until it is cleared."""

from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.lib.validate import check_integer
from hw.memsys.fault import Fault
from hw.memsys.memory_formats import MemoryFormats

__all__ = ["FirstFault"]


class FirstFault(wiring.Component):
    """Latches the first fault until it is cleared; of two in the same cycle that of the lower input.

    Parameters
    ----------
    config
        The configuration.
    count
        Number of inputs, at least 1.

    Members
    -------
    i : In, ``count`` streams of `MemoryFormats.fault`
        Faults. Always ready.
    clear : In(1)
        Clears the latch.
    o : Out(MemoryFormats.fault)
        The fault, all 0 while there is none.

    Timing
    ------
    Latency: ``1`` cycle.

    Raises
    ------
    TypeError
        The count is no integer.
    ValueError
        The count is out of range.
    """

    def __init__(self, *, config: Config, count: int):
        check_integer("Count", count, minimum=1)
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
