"""Store fill: fetched patches into their frames, or past them."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.formats import VERTICES, Formats
from hw.lib.checks import claim
from hw.lib.queue import Queue
from hw.memsys.patches.store_formats import StoreFormats
from hw.memsys.patches.void_check import VoidCheck

__all__ = ["StoreFill"]


class StoreFill(wiring.Component):
    """Serves with each patch that comes one of the entries that fetch it: the lowest.

    Parameters
    ----------
    config, frames, requests
        See `PatchStore`.

    Members
    -------
    i : In, stream of `Formats.patch_vertex`
        Fetched patches in any order; the four vertices of a patch one after the other.
    i_lost : In, stream of a patch id
        A fetch that has failed. Not between the vertices of a patch.
    entries : In(StoreFormats.entries)
        Each entry's request.
    fetching : In(requests)
        Entries whose patch is being fetched.
    write : In(StoreFormats.write)
        Writes vertices into frames.
    o : Out, stream of ``address``, ``data``
        A frame whose patch is complete, and what is known of it.
    o_passed : Out, stream of `Formats.patch_vertex`
        Patches that are not kept.
    filled, frees : Out(requests)
        The entry whose fetch ends in this cycle, and the same if its request ends too, one-hot or 0.
    lost : Out(1)
        A request that is not kept has ended without a patch.

    Timing
    ------
    Latency: ``1`` cycle from a vertex to its frame or to ``o_passed``. One vertex per cycle; stalls with ``o_passed``.

    Golden counterpart: `golden.engine.memsys.patches.patch_store.PatchStore`.
    """

    latency = 1

    def __init__(self, *, config: Config, frames: int, requests: int):
        self._config, self._requests, formats = config, requests, Formats(config)
        self._formats = store = StoreFormats(config=config, frames=frames, requests=requests)
        vertices = stream.Signature(formats.patch_vertex)
        super().__init__({
            "i": In(vertices), "i_lost": In(stream.Signature(formats.patch)), "entries": In(store.entries),
            "fetching": In(requests), "write": In(store.write),
            "o": Out(stream.Signature(StructLayout({"address": store.frame, "data": store.head}))),
            "o_passed": Out(vertices), "filled": Out(requests), "frees": Out(requests), "lost": Out(1)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.fills = fills = Queue(self.o.payload.shape(), depth=self._requests)
        m.submodules.check = check = VoidCheck(config=self._config)
        wiring.connect(m, fills.o, wiring.flipped(self.o))
        # A vertex waits a cycle for the entry of its patch.
        vertex, there, is_lost = Signal.like(self.i.payload, reset_less=True), Signal(), Signal()
        found, advances, ends = Signal(self._requests), Signal(), Signal()
        patch = Mux(self.i_lost.valid, self.i_lost.payload, self.i.payload.patch)
        first = Signal(range(VERTICES))
        takes_lost, takes = Signal(), Signal()
        m.d.comb += [
            takes_lost.eq(self.i_lost.valid & (first == 0)), self.i_lost.ready.eq(advances & (first == 0)),
            self.i.ready.eq(advances & ~takes_lost), takes.eq(self.i.valid & ~takes_lost)]
        with m.If(takes & self.i.ready):
            m.d.sync += first.eq(first + 1)
        # Of several fetches of a patch any one is served.
        candidates, each = Signal(self._requests), [self.entries[k] for k in range(self._requests)]
        m.d.comb += [self.filled.eq(Mux(ends, found, 0)),
                     candidates.eq(Cat(entry.patch == patch for entry in each) & self.fetching & ~self.filled)]
        claim(m, ~advances | ~(takes_lost | (takes & (first == 0))) | candidates.any(), "what comes is being fetched")
        with m.If(advances):
            m.d.sync += [there.eq(takes_lost | takes), is_lost.eq(takes_lost), vertex.eq(self.i.payload)]
            with m.If(takes_lost | (first == 0)):
                m.d.sync += found.eq(candidates & ~(candidates - 1))
        entry = Signal(self._formats.entry)
        for k, one in enumerate(each):
            with m.If(found[k]):
                m.d.comb += entry.eq(one)
        moves = there & advances
        m.d.comb += [
            check.vertex.eq(vertex.vertex), check.moves.eq(moves & ~is_lost),
            ends.eq(moves & (is_lost | (check.index == VERTICES - 1))),
            self.write.addr.eq(Cat(check.index, entry.frame)), self.write.data.vertex.eq(vertex.vertex),
            self.write.data.surface.eq(vertex.surface), self.write.en.eq(moves & entry.is_stored & ~is_lost),
            fills.i.valid.eq(ends & entry.is_stored), fills.i.payload.address.eq(entry.frame),
            fills.i.payload.data.is_lost.eq(is_lost), fills.i.payload.data.is_void.eq(check.void),
            self.o_passed.valid.eq(there & ~entry.is_stored & ~is_lost), self.o_passed.payload.eq(vertex),
            advances.eq(~self.o_passed.valid | self.o_passed.ready),
            self.frees.eq(Mux(entry.is_stored, 0, self.filled))]
        m.d.sync += self.lost.eq(ends & is_lost & ~entry.is_stored)
        return m
