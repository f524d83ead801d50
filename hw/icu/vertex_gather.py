"""Vertex gather: four vertices become a patch."""

from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import IcuFormats

__all__ = ["VertexGather"]


class VertexGather(wiring.Component):
    """Collects an item of each of a patch's four vertices.

    Parameters
    ----------
    config
        The configuration.
    shape
        Of a vertex' item.

    Members
    -------
    i : In, stream of ``slot``, ``index``, ``item``, always ready
        Items of vertices 0 to 3, in this order.
    o : Out, stream of ``slot``, ``items``, always ready
        The items of all four vertices.

    Timing
    ------
    Latency: ``1`` cycle from the fourth vertex. One vertex per cycle; nothing stalls.
    """

    def __init__(self, *, config: Config, shape):
        slot = IcuFormats(config).slot
        super().__init__({
            "i": In(stream.Signature(StructLayout({"slot": slot, "index": 2, "item": shape}), always_ready=True)),
            "o": Out(stream.Signature(StructLayout({"slot": slot, "items": ArrayLayout(shape, 4)}),
                                      always_ready=True))})
        self.latency = 1

    def elaborate(self, platform):
        m = Module()
        given, made = self.i.payload, self.o.payload
        m.d.sync += self.o.valid.eq(self.i.valid & (given.index == 3))
        # A shift register: an enable for each item would be a late signal with a high fan-out.
        with m.If(self.i.valid):
            m.d.sync += [made.slot.eq(given.slot), *(made.items[k].eq(made.items[k + 1]) for k in range(3)),
                         made.items[3].eq(given.item)]
        return m
