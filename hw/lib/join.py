"""Join: combines items of several streams into one item."""

from collections.abc import Mapping

from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

__all__ = ["Join"]


class Join(wiring.Component):
    """The n-th items of all inputs are the fields of the n-th item of the output.

    Parameters
    ----------
    shapes
        Of the items, by the names of the output's fields; at least one.

    Members
    -------
    i_<name> : In, stream of the shape of ``name``
        Items of field ``name``; all inputs are accepted together.
    o : Out, stream of a struct of all ``shapes``
        One item of each input.

    Timing
    ------
    Latency: ``0`` cycles. One item per cycle; stalls with ``o`` and with the slowest input; nothing in flight.

    Raises
    ------
    ValueError
        There are no shapes.
    """

    def __init__(self, shapes: Mapping):
        if not shapes:
            raise ValueError(f"Shapes must be at least one, not {shapes!r}")
        self._names = list(shapes)
        super().__init__({**{f"i_{name}": In(stream.Signature(shape)) for name, shape in shapes.items()},
                          "o": Out(stream.Signature(StructLayout(dict(shapes))))})
        self.latency = 0

    def elaborate(self, platform):
        m = Module()
        m.d.comb += self.o.valid.eq(1)
        for name in self._names:
            source = getattr(self, f"i_{name}")
            with m.If(~source.valid):
                m.d.comb += self.o.valid.eq(0)
            m.d.comb += [source.ready.eq(self.o.valid & self.o.ready), self.o.payload[name].eq(source.payload)]
        return m
