"""Skid buffer: registers between two streams, in both directions."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

__all__ = ["SkidBuffer"]


class SkidBuffer(wiring.Component):
    """Cuts all paths through a stream: ``valid``, ``payload`` and ``ready`` each come from a register.

    The item that is on its way while ``ready`` falls waits beside the output register.

    Parameters
    ----------
    shape
        Of an item.

    Members
    -------
    i, o
        Items.

    Timing
    ------
    Latency: ``1`` cycle. One item per cycle; stalls with ``o``, one cycle later; 2 items in flight.
    """

    def __init__(self, shape):
        super().__init__({"i": In(stream.Signature(shape)), "o": Out(stream.Signature(shape))})
        self.latency = 1

    def elaborate(self, platform):
        m = Module()
        waits = Signal()
        spare = Signal.like(self.i.payload, reset_less=True)
        shown = Signal.like(self.i.payload, reset_less=True)
        m.d.comb += [self.i.ready.eq(~waits), self.o.payload.eq(shown)]
        with m.If(self.i.ready):
            m.d.sync += spare.eq(self.i.payload)
        with m.If(self.o.ready | ~self.o.valid):
            m.d.sync += [shown.eq(Mux(waits, spare, self.i.payload)), self.o.valid.eq(waits | self.i.valid),
                         waits.eq(0)]
        with m.Else():
            m.d.sync += waits.eq(waits | self.i.valid)
        return m
