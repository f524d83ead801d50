"""Patch store: a cluster's copies of the patches that other clusters or main memory hold."""

from amaranth.hdl import Cat, Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.formats import Formats
from hw.lib.checks import claim, count_entries
from hw.lib.start_all import StartAll
from hw.memsys.patches.istructure import IStructure
from hw.memsys.patches.path_formats import PathFormats
from hw.memsys.patches.store_fill import StoreFill
from hw.memsys.patches.store_formats import StoreFormats
from hw.memsys.patches.store_lookup import StoreLookup
from hw.memsys.patches.store_read import StoreRead

__all__ = ["PatchStore"]


class PatchStore(wiring.Component):
    """Fetches each patch once for all requests that wait for it, and keeps some of them.

    ::

        i - StoreLookup -+- o_fetch         i_fill, i_lost - StoreFill -+- IStructure - StoreRead - o_stored
                         '- IStructure (renew, read)                    '- o_passed

    Patch p belongs into frame p modulo ``frames``. A request finds its patch in the frame, or in flight to it: then it
    waits in the `IStructure` without another fetch. Otherwise the patch is fetched. It is kept if the frame is empty,
    and at every `KEPT_OF`-th request that meets another patch there: each frustum needs about the same patches, more
    than the frames, in about the same order, so a patch that each miss replaces would be gone before its next request.
    What is not kept is passed on. A frame with a request in flight is not renewed: the request waits for its last
    answer. A fill never stalls but with ``o_passed``.

    A patch whose vertices are all 0 comes from a cluster that does not hold it, see `VoidCheck`. It is answered and not
    kept, so a later frustum fetches it again.

    Parameters
    ----------
    config
        The configuration.
    frames
        Patches that are kept, a power of two, at least 2.
    requests
        Requests in flight, a power of two, at least 2.

    Members
    -------
    i_start : In, stream without payload
        Empties the store, needed after a reset too. Accepted when no request is in flight.
    i : In, stream of `PathFormats.store_request`
        Requests. Accepted while fewer than ``requests`` are in flight.
    o_fetch : Out, stream of `PathFormats.store_request`
        Patches to fetch, in the order of their requests.
    i_fill : In, stream of `Formats.patch_vertex`
        Fetched patches in any order; the four vertices of a patch one after the other.
    i_lost : In, stream of a patch id
        A fetch that has failed. Not between the vertices of a patch.
    o_stored : Out, stream of `Formats.patch_vertex`
        Patches from their frames.
    o_passed : Out, stream of `Formats.patch_vertex`
        Patches that were not kept. Each request is answered at one of both, or lost.
    lost : Out(2)
        Requests that end without a patch, a bit for each; the fetch has failed. The frame keeps nothing.
    hits : Out(32)
        Requests without a fetch, since reset.
    deferred : Out(32)
        Requests that have waited in the `IStructure`, since reset.

    Timing
    ------
    A request every three cycles, unless it waits for its frame, so a patch every four. Latency: ``10`` cycles from a
    request whose patch is kept to its first vertex, ``3`` from a request to ``o_fetch``. Fills come at one vertex per
    cycle.

    Raises
    ------
    TypeError
        A number is no integer.
    ValueError
        A number is no power of two, or too small.

    Golden counterpart: `golden.engine.memsys.patches.patch_store.PatchStore`. Source: Shen 1993, section 5.2.4.1, for
    the I-structure.
    """

    latency = 10

    def __init__(self, *, config: Config, frames: int, requests: int = 16):
        self._parts = {"config": config, "frames": frames, "requests": requests}
        self._formats, formats = StoreFormats(**self._parts), Formats(config)
        self._frames, self._requests = frames, requests
        request, vertices = stream.Signature(PathFormats(config).store_request), stream.Signature(formats.patch_vertex)
        super().__init__({
            "i_start": In(stream.Signature(0)), "i": In(request), "o_fetch": Out(request), "i_fill": In(vertices),
            "i_lost": In(stream.Signature(formats.patch)), "o_stored": Out(vertices), "o_passed": Out(vertices),
            "lost": Out(2), "hits": Out(32), "deferred": Out(32)})
        # Entries in flight; the memory system checks that all are free when a frustum begins.
        self.taken = Signal(requests)

    def elaborate(self, platform):
        m = Module()
        m.submodules.lookup, m.submodules.fill = lookup, fill = StoreLookup(**self._parts), StoreFill(**self._parts)
        m.submodules.read = read = StoreRead(**self._parts)
        m.submodules.istructure = presence = IStructure(
            self._formats.head, depth=self._frames, version_bits=self._formats.version_bits, deferred=self._requests,
            tag=self._formats.number, renews=True)
        for source, target in (
                (wiring.flipped(self.i), lookup.i), (lookup.o_fetch, wiring.flipped(self.o_fetch)),
                (lookup.o_renew, presence.i_renew), (lookup.o_read, presence.i_read),
                (wiring.flipped(self.i_fill), fill.i), (wiring.flipped(self.i_lost), fill.i_lost),
                (fill.o_passed, wiring.flipped(self.o_passed)), (fill.o, presence.i_write), (fill.write, read.write),
                (presence.o_read, read.i), (read.o, wiring.flipped(self.o_stored)), (read.o_forget, lookup.i_forget)):
            wiring.connect(m, source, target)

        # Tags and presence bits begin together, without a request in flight.
        m.submodules.start = start = StartAll(count=2)
        begun, taken, fetching = Signal(), self.taken, Signal(self._requests)
        for output, part in zip(start.o, (lookup, presence), strict=True):
            wiring.connect(m, output, part.i_start)
        m.d.comb += [start.i.valid.eq(self.i_start.valid & ~lookup.busy & ~taken.any()),
                     self.i_start.ready.eq(start.i.ready), lookup.is_open.eq(begun & ~self.i_start.valid)]
        with m.If(start.i.ready):
            m.d.sync += begun.eq(1)

        frees = fill.frees | read.frees
        m.d.comb += [lookup.taken.eq(taken), fill.fetching.eq(fetching), fill.entries.eq(lookup.entries),
                     read.entries.eq(lookup.entries), self.lost.eq(Cat(fill.lost, read.lost)),
                     self.hits.eq(lookup.hits)]
        m.d.sync += [self.deferred.eq(self.deferred + presence.defers), taken.eq((taken | lookup.takes) & ~frees),
                     fetching.eq((fetching | lookup.fetches) & ~fill.filled)]
        count_entries(sum(taken))
        claim(m, ~presence.o_refused.valid, "what is written was absent")
        claim(m, (fetching & ~taken) == 0, "what is fetched has an entry")
        claim(m, (frees & ~taken) == 0, "an entry is freed once")
        return m
