"""Vertex merge: whole patches of several sources."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.formats import VERTICES, Formats
from hw.lib.checks import count_entries, count_up_down
from hw.lib.longest_waiting import LongestWaiting
from hw.lib.queue import Queue
from hw.lib.validate import check_integer

__all__ = ["VertexMerge"]

# Capacity for each source in patches.
PATCHES = 4


class VertexMerge(wiring.Component):
    """Merges the vertices of several sources. The vertices of a patch stay together.

    A patch is eligible when all of its vertices have arrived, so a slow source stalls no other. The patch that has been
    eligible longest is granted.

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
    Latency: ``2`` cycles from the last vertex of a patch to its first one, if no other source is granted. One vertex
    per cycle, without a gap between patches; stalls with ``o``.

    Raises
    ------
    TypeError
        The count is no integer.
    ValueError
        The count is out of range.
    """

    def __init__(self, *, config: Config, count: int):
        check_integer("Count", count, minimum=1)
        self._count, self._vertex = count, Formats(config).patch_vertex
        vertices = stream.Signature(self._vertex)
        super().__init__({"i": In(vertices).array(count), "o": Out(vertices), "left": Out(count)})
        self.latency = 2

    def elaborate(self, platform):
        m = Module()
        m.submodules.arbiter = arbiter = LongestWaiting(count=self._count)
        busy, chosen, index = Signal(), Signal(range(self._count)), Signal(range(VERTICES))
        moves, ends, eligible, free, last = Signal(), Signal(), Signal(self._count), Signal(), Signal()
        m.d.comb += [moves.eq(self.o.valid & self.o.ready), ends.eq(moves & last),
                     free.eq(~busy | ends), arbiter.request.eq(eligible), arbiter.eligible.eq(eligible),
                     arbiter.accept.eq(free & eligible.any())]
        with m.If(moves):
            m.d.sync += [index.eq(index + 1), last.eq(index == VERTICES - 2)]
        with m.If(free):
            m.d.sync += busy.eq(eligible.any())
        queues = []
        for k, source in enumerate(self.i):
            m.submodules[f"queue_{k}"] = queue = Queue(self._vertex, depth=VERTICES * PATCHES)
            queues.append(queue.o)
            wiring.connect(m, wiring.flipped(source), queue.i)
            # Patches that have arrived in full and have not been granted.
            vertex, whole = Signal(range(VERTICES)), Signal(range(PATCHES + 1))
            enters, arrives, granted = Signal(), Signal(), Signal()
            m.d.comb += [enters.eq(source.valid & source.ready), arrives.eq(enters & (vertex == VERTICES - 1)),
                         granted.eq(free & arbiter.grant[k]), self.left[k].eq(ends & (chosen == k))]
            with m.If(enters):
                m.d.sync += vertex.eq(vertex + 1)
            # Whether a patch is granted is known late.
            m.d.sync += eligible[k].eq(arrives | Mux(granted, whole[1:].any(), eligible[k]))
            count_entries(whole)
            count_up_down(m, whole, up=arrives, down=granted, most=PATCHES)
            with m.If(granted):
                m.d.sync += chosen.eq(k)
        with m.Switch(chosen):
            for k, queue in enumerate(queues):
                with m.Case(k):
                    m.d.comb += [self.o.payload.eq(queue.payload), queue.ready.eq(self.o.ready & busy)]
        m.d.comb += self.o.valid.eq(busy)
        return m
