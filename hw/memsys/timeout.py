"""Time-out: says when a wait has lasted too long."""

from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

__all__ = ["Timeout"]


class Timeout(wiring.Component):
    """``expired`` while something has waited for 2^``bits`` cycles in which nothing moved.

    Parameters
    ----------
    bits
        See above, at least 1.

    Members
    -------
    waits, moves
        Something waits for an answer; something went on in this cycle.
    expired
        See above.

    Timing
    ------
    Latency: ``2**bits`` cycles.

    Errors
    ------
    ValueError
        Bits out of range.
    """

    def __init__(self, *, bits: int):
        if not isinstance(bits, int) or bits < 1:
            raise ValueError(f"Bits must be at least 1, not {bits!r}")
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
