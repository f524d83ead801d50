"""Vertex gate: lets the vertices of whole patches pass."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.formats import VERTICES
from hw.icu.icu_formats import IcuFormats

__all__ = ["VertexGate"]


class VertexGate(wiring.Component):
    """While it is closed no patch begins; a patch that has begun passes in full, and an offer that was made stays.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `Formats.patch_vertex`
        The four vertices of a patch follow each other.
    o : Out, stream of `Formats.patch_vertex`
        The same vertices.
    is_open : In(1)
        A patch may begin.
    begins : Out(1)
        The first vertex of a patch passes.

    Timing
    ------
    Latency: ``0`` cycles. One vertex per cycle; stalls with ``o``, and before a patch while it is closed.
    """

    def __init__(self, *, config: Config):
        vertices = stream.Signature(IcuFormats(config).patch_vertex)
        super().__init__({"i": In(vertices), "o": Out(vertices), "is_open": In(1), "begins": Out(1)})
        self.latency = 0

    def elaborate(self, platform):
        m = Module()
        vertex, is_offered, passes = Signal(range(VERTICES)), Signal(), Signal()
        m.d.comb += [passes.eq(self.is_open | (vertex != 0) | is_offered), self.o.valid.eq(self.i.valid & passes),
                     self.o.payload.eq(self.i.payload), self.i.ready.eq(self.o.ready & passes),
                     self.begins.eq(self.o.valid & self.o.ready & (vertex == 0))]
        m.d.sync += is_offered.eq(self.o.valid & ~self.o.ready)
        with m.If(self.o.valid & self.o.ready):
            m.d.sync += vertex.eq(vertex + 1)
        return m
