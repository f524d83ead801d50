"""Queue: first in, first out."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

__all__ = ["Queue"]


class Queue(wiring.Component):
    """Keeps items in order, and their shape.

    In distributed memory: for what is short or narrow.

    Parameters
    ----------
    shape
        Of an item.
    depth
        Items that it holds, at least 1.

    Members
    -------
    i, o
        Items.
    level
        Items that it holds now.

    Timing
    ------
    Latency: ``1`` cycle. One item per cycle in and out; stalls ``i`` while it is full.

    Errors
    ------
    ValueError
        Depth out of range.
    """

    def __init__(self, shape, *, depth: int):
        if not isinstance(depth, int) or depth < 1:
            raise ValueError(f"Depth must be at least 1, not {depth!r}")
        self._shape, self._depth = shape, depth
        super().__init__({"i": In(stream.Signature(shape)), "o": Out(stream.Signature(shape)),
                          "level": Out(range(depth + 1))})
        self.latency = 1

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = memory = Memory(shape=self._shape, depth=self._depth, init=[],
                                              attrs={"ram_style": "distributed"})
        write, read = memory.write_port(), memory.read_port(domain="comb")
        first, last = (Signal(range(self._depth)) for _ in range(2))
        put, take = self.i.valid & self.i.ready, self.o.valid & self.o.ready

        def after(place):
            return Mux(place == self._depth - 1, 0, place + 1)

        m.d.comb += [
            self.i.ready.eq(self.level != self._depth), self.o.valid.eq(self.level != 0),
            write.addr.eq(last), write.data.eq(self.i.payload), write.en.eq(put),
            read.addr.eq(first), self.o.payload.eq(read.data)]
        with m.If(put):
            m.d.sync += last.eq(after(last))
        with m.If(take):
            m.d.sync += first.eq(after(first))
        m.d.sync += self.level.eq(self.level + put - take)
        return m
