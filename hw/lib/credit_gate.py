"""Credit gate: lets in what there is room for further on."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

__all__ = ["CreditGate"]


class CreditGate(wiring.Component):
    """An item takes a credit with it, and waits while there is none.

    Stands in front of what cannot wait itself, with a queue of ``credits`` places behind it: a credit comes back when
    an item leaves the queue.

    Parameters
    ----------
    shape
        Of an item.
    credits
        Items that may be on their way, at least 1.

    Members
    -------
    i, o
        Items.
    i_return
        A credit comes back; it can be used from the next cycle on. No payload, always ready. Comes at most once for
        each item.
    level
        Items that are on their way now.

    Timing
    ------
    Latency: ``0`` cycles. One item per cycle; stalls with ``o``, and while all credits are taken.

    Errors
    ------
    ValueError
        Credits out of range.
    """

    def __init__(self, shape, *, credits: int):
        if not isinstance(credits, int) or credits < 1:
            raise ValueError(f"Credits must be at least 1, not {credits!r}")
        self._credits = credits
        super().__init__({"i": In(stream.Signature(shape)), "o": Out(stream.Signature(shape)),
                          "i_return": In(stream.Signature(0, always_ready=True)), "level": Out(range(credits + 1))})
        self.latency = 0

    def elaborate(self, platform):
        m = Module()
        passes = Signal()
        free = self.level != self._credits
        m.d.comb += [self.o.payload.eq(self.i.payload), self.o.valid.eq(self.i.valid & free),
                     self.i.ready.eq(self.o.ready & free), passes.eq(self.o.valid & self.o.ready)]
        m.d.sync += self.level.eq(self.level + passes - self.i_return.valid)
        return m
