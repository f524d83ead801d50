"""Vertex merge: patches of several sources, each of them whole."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.formats import Formats
from hw.lib.longest_waiting import LongestWaiting
from hw.lib.queue import Queue

__all__ = ["VertexMerge"]

VERTICES = 4


class VertexMerge(wiring.Component):
    """Lets a patch go when all of it is there, so that its vertices stay together and no slow source holds up others.

    The source that has waited longest goes first.

    Parameters
    ----------
    config
        The configuration.
    count
        Sources, at least 1.
    patches
        Patches of a source that wait, at least 2.

    Members
    -------
    i
        An array of `Formats.patch_vertex`; four vertices of a patch follow each other.
    o
        `Formats.patch_vertex`.
    left
        The last vertex of a patch of this source leaves in this cycle.

    Timing
    ------
    Latency: ``2`` cycles from the last vertex of a patch to its first one, if nobody else goes first. One vertex per
    cycle, without a gap between patches; stalls with ``o``.

    Errors
    ------
    ValueError
        Count or patches out of range.
    """

    def __init__(self, *, config: Config, count: int, patches: int = 4):
        if not isinstance(count, int) or count < 1:
            raise ValueError(f"Count must be at least 1, not {count!r}")
        if not isinstance(patches, int) or patches < 2:
            raise ValueError(f"Patches must be at least 2, not {patches!r}")
        self._count, self._patches, self._vertex = count, patches, Formats(config).patch_vertex
        vertices = stream.Signature(self._vertex)
        super().__init__({"i": In(vertices).array(count), "o": Out(vertices), "left": Out(count)})
        self.latency = 2

    def elaborate(self, platform):
        m = Module()
        m.submodules.turns = turns = LongestWaiting(count=self._count)
        busy, chosen, index = Signal(), Signal(range(self._count)), Signal(range(VERTICES))
        moves, ends, asks, free = Signal(), Signal(), Signal(self._count), Signal()
        m.d.comb += [moves.eq(self.o.valid & self.o.ready), ends.eq(moves & (index == VERTICES - 1)),
                     free.eq(~busy | ends), turns.request.eq(asks), turns.eligible.eq(asks),
                     turns.accept.eq(free & asks.any())]
        with m.If(moves):
            m.d.sync += index.eq(index + 1)
        with m.If(free):
            m.d.sync += busy.eq(asks.any())
        queues = []
        for k, source in enumerate(self.i):
            m.submodules[f"queue_{k}"] = queue = Queue(self._vertex, depth=VERTICES * self._patches)
            queues.append(queue.o)
            wiring.connect(m, wiring.flipped(source), queue.i)
            # Patches that are there in full and have not got their turn.
            place, whole = Signal(range(VERTICES)), Signal(range(self._patches + 1))
            enters, goes = Signal(), Signal()
            m.d.comb += [enters.eq(source.valid & source.ready), goes.eq(free & turns.grant[k]),
                         asks[k].eq(whole != 0), self.left[k].eq(ends & (chosen == k))]
            with m.If(enters):
                m.d.sync += place.eq(place + 1)
            m.d.sync += whole.eq(whole + (enters & (place == VERTICES - 1)) - goes)
            with m.If(goes):
                m.d.sync += chosen.eq(k)
        with m.Switch(chosen):
            for k, queue in enumerate(queues):
                with m.Case(k):
                    m.d.comb += [self.o.payload.eq(queue.payload), queue.ready.eq(self.o.ready & busy)]
        m.d.comb += self.o.valid.eq(busy)
        return m
