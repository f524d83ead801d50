"""Credit gate: bounds the items in flight behind it."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hw.lib.checks import count_entries, count_up_down
from hw.lib.validate import check_integer

__all__ = ["CreditGate"]


class CreditGate(wiring.Component):
    """Each item takes a credit; without one it stalls.

    It stands in front of a unit that cannot stall, with a queue of ``credits`` entries behind: a credit returns when an
    item leaves the queue.

    Parameters
    ----------
    shape
        Of an item.
    credits
        Items that may be in flight, at least 1.

    Members
    -------
    i : In, stream of the item's shape
        Items.
    o : Out, stream of the item's shape
        The same items.
    i_return : In, stream without payload, always ready
        Credit return; usable from the next cycle on. At most once per item.
    level : Out(range(credits + 1))
        Items in flight.

    Timing
    ------
    Latency: ``0`` cycles. One item per cycle; stalls with ``o``, and without credits.

    Raises
    ------
    TypeError
        The credits are no integer.
    ValueError
        The credits are out of range.
    """

    def __init__(self, shape, *, credits: int):
        check_integer("Credits", credits, minimum=1)
        self._credits = credits
        super().__init__({"i": In(stream.Signature(shape)), "o": Out(stream.Signature(shape)),
                          "i_return": In(stream.Signature(0, always_ready=True)), "level": Out(range(credits + 1))})
        self.latency = 0

    def elaborate(self, platform):
        m = Module()
        transfer = Signal()
        # A register, known a step ahead.
        free = Signal(init=1)
        m.d.sync += free.eq(self.i_return.valid | (free & ~(transfer & (self.level == self._credits - 1))))
        m.d.comb += [self.o.payload.eq(self.i.payload), self.o.valid.eq(self.i.valid & free),
                     self.i.ready.eq(self.o.ready & free), transfer.eq(self.o.valid & self.o.ready)]
        count_entries(self.level)
        count_up_down(m, self.level, up=transfer, down=self.i_return.valid, most=self._credits)
        return m
