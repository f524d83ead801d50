"""Fork: one stream to several takers."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

__all__ = ["Fork"]


class Fork(wiring.Component):
    """Gives each item to every output once; the outputs take it in different cycles if they like.

    Parameters
    ----------
    shape
        Of an item.
    count
        Outputs, at least 1.

    Members
    -------
    i
        Items; one is taken when its last output takes it.
    o
        An array of streams.

    Timing
    ------
    Latency: ``0`` cycles. One item per cycle; stalls with the slowest output; the others are one item ahead of it at
    most.

    Errors
    ------
    ValueError
        Count out of range.
    """

    def __init__(self, shape, *, count: int):
        if not isinstance(count, int) or count < 1:
            raise ValueError(f"Count must be at least 1, not {count!r}")
        self._count = count
        super().__init__({"i": In(stream.Signature(shape)), "o": Out(stream.Signature(shape)).array(count)})
        self.latency = 0

    def elaborate(self, platform):
        m = Module()
        # Outputs that have the present item, before this cycle and after it.
        had, has = Signal(self._count), Signal(self._count)
        for k, output in enumerate(self.o):
            m.d.comb += [output.payload.eq(self.i.payload), output.valid.eq(self.i.valid & ~had[k]),
                         has[k].eq(had[k] | output.ready)]
        m.d.comb += self.i.ready.eq(has.all())
        with m.If(self.i.valid):
            m.d.sync += had.eq(has)
            with m.If(self.i.ready):
                m.d.sync += had.eq(0)
        return m
