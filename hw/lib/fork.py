"""Fork: copies one stream to several."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hw.lib.validate import check_integer

__all__ = ["Fork"]


class Fork(wiring.Component):
    """Each item is transferred once to every output; outputs may accept it in different cycles.

    Parameters
    ----------
    shape
        Of an item.
    count
        Number of outputs, at least 1.

    Members
    -------
    i : In, stream of the item's shape
        Items; one is accepted together with its last copy.
    o : Out, ``count`` streams of the item's shape
        The copies.

    Timing
    ------
    Latency: ``0`` cycles. One item per cycle; stalls with the slowest output; the others are at most one item ahead.

    Raises
    ------
    TypeError
        The count is no integer.
    ValueError
        The count is out of range.
    """

    def __init__(self, shape, *, count: int):
        check_integer("Count", count, minimum=1)
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
