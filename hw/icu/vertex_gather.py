"""Vertex gather: what the four vertices of a patch gave, side by side."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.formats import Formats

__all__ = ["VertexGather"]


class VertexGather(wiring.Component):
    """Collects items with the indices 0 to 3, in this order, into one of all four.

    Parameters
    ----------
    shape
        Of what a vertex gives.
    config
        The configuration.

    Members
    -------
    i
        ``slot``, ``index`` 0 to 3, ``item``. Always ready.
    o
        ``slot`` of the last, ``items``. Always ready. The payload stays until the next patch is complete, so for at
        least four cycles.

    Timing
    ------
    Latency: ``1`` cycle from the last of the four. One vertex per cycle; nothing stalls.
    """

    def __init__(self, shape, *, config: Config):
        slot = Formats(config).slot
        self._shape = shape
        super().__init__({
            "i": In(stream.Signature(StructLayout({"slot": slot, "index": 2, "item": shape}), always_ready=True)),
            "o": Out(stream.Signature(StructLayout({"slot": slot, "items": ArrayLayout(shape, 4)}),
                                      always_ready=True))})
        self.latency = 1

    def elaborate(self, platform):
        m = Module()
        given, made = self.i.payload, self.o.payload
        # The first three wait beside the output, which must not change while the next patch comes in.
        early = [Signal(self._shape, reset_less=True, name=f"early_{index}") for index in range(3)]
        slot, items = Signal.like(made.slot, reset_less=True), Signal.like(made["items"], reset_less=True)
        complete = Signal()
        m.d.comb += [complete.eq(self.i.valid & (given.index == 3)), made.slot.eq(slot), made["items"].eq(items)]
        m.d.sync += self.o.valid.eq(complete)
        with m.If(complete):
            m.d.sync += slot.eq(given.slot)
            m.d.sync += [items[index].eq(value) for index, value in enumerate([*early, given.item])]
        for index, value in enumerate(early):
            with m.If(self.i.valid & (given.index == index)):
                m.d.sync += value.eq(given.item)
        return m
