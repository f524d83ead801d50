"""Patch merge: patches of several sources, without buffers."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.formats import VERTICES, Formats
from hw.lib.longest_waiting import LongestWaiting
from hw.lib.validate import check_integer

__all__ = ["PatchMerge"]


class PatchMerge(wiring.Component):
    """Merges the vertices of several sources. The vertices of a patch stay together.

    A source whose first vertex has come is granted until its patch has left, so a source that stalls within a patch
    stalls the others: `VertexMerge` waits for whole patches. Of several the one that has been pending longest is
    granted.

    Parameters
    ----------
    config
        The configuration.
    count
        Number of sources, at least 1.

    Members
    -------
    i : In, ``count`` streams of `Formats.patch_vertex`
        The four vertices of each patch, one after the other.
    o : Out, stream of `Formats.patch_vertex`
        The same.
    left : Out(count)
        The last vertex of a patch of this source leaves in this cycle.

    Timing
    ------
    Latency: ``1`` cycle from the first vertex of a patch to the same one at ``o``, ``0`` of the others. One vertex per
    cycle, with a gap of a cycle between patches of the same source; stalls with ``o``.

    Raises
    ------
    TypeError
        The number is no integer.
    ValueError
        The number is out of range.
    """

    latency = 1

    def __init__(self, *, config: Config, count: int):
        check_integer("Count", count, minimum=1)
        self._count = count
        vertices = stream.Signature(Formats(config).patch_vertex)
        super().__init__({"i": In(vertices).array(count), "o": Out(vertices), "left": Out(count)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.arbiter = arbiter = LongestWaiting(count=self._count)
        busy, chosen, index = Signal(), Signal(range(self._count)), Signal(range(VERTICES))
        ends, free = Signal(), Signal()
        m.d.comb += [ends.eq(self.o.valid & self.o.ready & (index == VERTICES - 1)), free.eq(~busy | ends),
                     arbiter.eligible.eq(arbiter.request), arbiter.accept.eq(free & arbiter.request.any())]
        with m.If(self.o.valid & self.o.ready):
            m.d.sync += index.eq(index + 1)
        with m.If(free):
            m.d.sync += busy.eq(arbiter.request.any())
        for k, source in enumerate(self.i):
            granted = busy & (chosen == k)
            m.d.comb += [arbiter.request[k].eq(source.valid & ~granted), self.left[k].eq(ends & granted)]
            with m.If(free & arbiter.grant[k]):
                m.d.sync += chosen.eq(k)
            with m.If(granted):
                m.d.comb += [self.o.valid.eq(source.valid), self.o.payload.eq(source.payload),
                             source.ready.eq(self.o.ready)]
        return m
