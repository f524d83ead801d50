"""Skid buffer: registers a stream in both directions."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

__all__ = ["SkidBuffer"]


class SkidBuffer(wiring.Component):
    """Cuts all combinational paths of a stream: ``valid``, ``payload`` and ``ready`` each come from a register.

    A second register holds the item that arrives while ``ready`` falls.

    Parameters
    ----------
    shape
        Of an item.

    Members
    -------
    i : In, stream of the item's shape
        Items.
    o : Out, stream of the item's shape
        The same items.
    ready_next : Out(1)
        ``i.ready`` in the next cycle; combinational from ``i.valid`` and ``o.ready``. For registers of the sender.

    Timing
    ------
    Latency: ``1`` cycle. One item per cycle; stalls with ``o``, one cycle later; 2 items in flight.
    """

    def __init__(self, shape):
        super().__init__({"i": In(stream.Signature(shape)), "o": Out(stream.Signature(shape)), "ready_next": Out(1)})
        self.latency = 1

    def elaborate(self, platform):
        m = Module()
        is_full = Signal()
        skid = Signal.like(self.i.payload, reset_less=True)
        output = Signal.like(self.i.payload, reset_less=True)
        leaves = self.o.ready | ~self.o.valid
        m.d.comb += [self.i.ready.eq(~is_full), self.o.payload.eq(output),
                     self.ready_next.eq(leaves | ~(is_full | self.i.valid))]
        m.d.sync += is_full.eq(~self.ready_next)
        with m.If(self.i.ready):
            m.d.sync += skid.eq(self.i.payload)
        with m.If(leaves):
            m.d.sync += [output.eq(Mux(is_full, skid, self.i.payload)), self.o.valid.eq(is_full | self.i.valid)]
        return m
