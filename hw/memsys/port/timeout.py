"""Time-out: detects a wait that has lasted too long."""

from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hw.lib.validate import check_integer

__all__ = ["Timeout"]


class Timeout(wiring.Component):
    """``expired`` after 2^``bits`` cycles of waiting without progress, until there is progress.

    Parameters
    ----------
    bits
        At least 1.

    Members
    -------
    waits, moves : In(1)
        An answer is outstanding; there is progress in this cycle.
    expired : Out(1)
        The wait has lasted too long.

    Timing
    ------
    Latency: ``2**bits`` cycles.

    Raises
    ------
    TypeError
        The number of bits is no integer.
    ValueError
        The number of bits is out of range.
    """

    def __init__(self, *, bits: int):
        check_integer("Bits", bits, minimum=1)
        self._bits = bits
        super().__init__({"waits": In(1), "moves": In(1), "expired": Out(1)})
        self.latency = 1 << bits

    def elaborate(self, platform):
        m = Module()
        count = Signal(self._bits + 1)
        m.d.comb += self.expired.eq(count[-1])
        with m.If(~self.waits | self.moves):
            m.d.sync += count.eq(0)
        with m.Elif(~self.expired):
            m.d.sync += count.eq(count + 1)
        return m
