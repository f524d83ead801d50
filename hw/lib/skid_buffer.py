"""Skid buffer: registers a stream in both directions."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hw.lib.validate import check_instance

__all__ = ["SkidBuffer"]


class SkidBuffer(wiring.Component):
    """Cuts all combinational paths of a stream: ``valid``, ``payload`` and ``ready`` each come from a register.

    A second register holds the item that arrives while ``ready`` falls. With ``bypass`` it is the only one, and cuts
    ``ready`` alone: an item passes in its own cycle if none waits.

    Parameters
    ----------
    shape
        Of an item.
    bypass
        Register ``ready`` alone.

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
    Latency: ``1 - bypass`` cycles. One item per cycle; stalls with ``o``, one cycle later; ``2 - bypass`` items in
    flight.

    Raises
    ------
    TypeError
        ``bypass`` is no boolean.
    """

    def __init__(self, shape, *, bypass: bool = False):
        check_instance("Bypass", bypass, bool)
        self._bypass = bypass
        super().__init__({"i": In(stream.Signature(shape)), "o": Out(stream.Signature(shape)), "ready_next": Out(1)})
        self.latency = 1 - bypass

    def elaborate(self, platform):
        m = Module()
        is_full = Signal()
        spare = Signal.like(self.i.payload, reset_less=True)
        leaves, is_some = self.o.ready | ~self.o.valid, is_full | self.i.valid
        first = Mux(is_full, spare, self.i.payload)
        m.d.comb += [self.i.ready.eq(~is_full), self.ready_next.eq(leaves | ~is_some)]
        m.d.sync += is_full.eq(~self.ready_next)
        with m.If(self.i.ready):
            m.d.sync += spare.eq(self.i.payload)
        if self._bypass:
            m.d.comb += [self.o.valid.eq(is_some), self.o.payload.eq(first)]
        else:
            output = Signal.like(self.i.payload, reset_less=True)
            m.d.comb += self.o.payload.eq(output)
            with m.If(leaves):
                m.d.sync += [output.eq(first), self.o.valid.eq(is_some)]
        return m
