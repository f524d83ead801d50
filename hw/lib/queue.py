"""Queue: first in, first out."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from hw.lib.checks import count_up_down
from hw.lib.validate import check_integer

__all__ = ["Queue"]


class Queue(wiring.Component):
    """A FIFO whose items keep their shape, in distributed memory: for short or narrow ones.

    Parameters
    ----------
    shape
        Of an item.
    depth
        Capacity in items, at least 1.

    Members
    -------
    i : In, stream of the item's shape
        Items.
    o : Out, stream of the item's shape
        The same items.
    level : Out(range(depth + 1))
        Items in the queue.

    Timing
    ------
    Latency: ``1`` cycle. One item per cycle in and out; stalls ``i`` while ``depth`` items are in flight.

    Raises
    ------
    TypeError
        The depth is no integer.
    ValueError
        The depth is out of range.
    """

    def __init__(self, shape, *, depth: int):
        check_integer("Depth", depth, minimum=1)
        self._shape, self._depth = shape, depth
        super().__init__({"i": In(stream.Signature(shape)), "o": Out(stream.Signature(shape)),
                          "level": Out(range(depth + 1))})
        self.latency = 1

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = memory = Memory(shape=self._shape, depth=self._depth, init=[],
                                              attrs={"ram_style": "distributed"})
        write, read = memory.write_port(), memory.read_port(domain="comb")
        head, tail = (Signal(range(self._depth)) for _ in range(2))
        put, take = self.i.valid & self.i.ready, self.o.valid & self.o.ready
        # Registers, known a step ahead: whether there is an item, or room for one, decides what others do.
        is_full, is_some = Signal(), Signal()
        m.d.sync += [is_full.eq(~take & (is_full | (put & (self.level == self._depth - 1)))),
                     is_some.eq(put | (is_some & ~(take & (self.level == 1))))]

        def after(entry):
            return Mux(entry == self._depth - 1, 0, entry + 1)

        m.d.comb += [
            self.i.ready.eq(~is_full), self.o.valid.eq(is_some),
            write.addr.eq(tail), write.data.eq(self.i.payload), write.en.eq(put),
            read.addr.eq(head), self.o.payload.eq(read.data)]
        with m.If(put):
            m.d.sync += tail.eq(after(tail))
        with m.If(take):
            m.d.sync += head.eq(after(head))
        count_up_down(m, self.level, up=put, down=take, most=self._depth)
        return m
