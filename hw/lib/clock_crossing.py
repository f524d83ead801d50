"""Clock crossing: carries a stream from one clock domain to another."""

from amaranth.hdl import Module, ResetSignal, Shape
from amaranth.lib import stream, wiring
from amaranth.lib.fifo import AsyncFIFO
from amaranth.lib.wiring import In, Out

from hw.lib.validate import check_power_of_two

__all__ = ["ClockCrossing"]


class ClockCrossing(wiring.Component):
    """The items of a stream in another clock domain, in order, by Amaranth's asynchronous queue with Gray counters.

    Parameters
    ----------
    shape
        Of an item.
    source, sink
        The domains of ``i`` and of ``o``. Their resets must overlap for at least three edges of both clocks: else the
        queue's counters differ, and items are lost or made up.
    depth
        Items in flight, a power of two of at least 4. From 16 on one item per cycle of the slower clock crosses.

    Members
    -------
    i : In, stream of the item's shape
        Items, in ``source``. Not ready during its reset.
    o : Out, stream of the item's shape
        The same items, in ``sink``. Not valid during its reset.

    Timing
    ------
    Latency: 1 cycle of ``source``, then 2 to 3 of ``sink``. One item per cycle of the slower clock. Stalls ``i`` while
    ``depth`` items are in flight; an item leaves room after 1 cycle of ``sink``, then 3 to 4 of ``source``.

    Raises
    ------
    TypeError
        The depth is no integer.
    ValueError
        The depth is no such power of two.
    """

    def __init__(self, shape, *, source: str, sink: str, depth: int = 16):
        check_power_of_two("Depth", depth, minimum=4)
        self._shape, self._source, self._sink, self._depth = shape, source, sink, depth
        super().__init__({"i": In(stream.Signature(shape)), "o": Out(stream.Signature(shape))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.queue = queue = AsyncFIFO(width=Shape.cast(self._shape).width, depth=self._depth,
                                               w_domain=self._source, r_domain=self._sink)
        # The other domain may end its reset first: what it sends waits.
        takes, gives = ~ResetSignal(self._source), ~ResetSignal(self._sink)
        m.d.comb += [
            self.i.ready.eq(queue.w_rdy & takes), queue.w_en.eq(self.i.valid),
            queue.w_data.eq(self.i.payload),
            self.o.valid.eq(queue.r_rdy & gives), queue.r_en.eq(self.o.ready & gives),
            self.o.payload.eq(queue.r_data)]
        return m
