"""System bus interface: the clusters' requests for cells and patches, from the caches or from main memory."""

from amaranth.hdl import Array, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.formats import Formats
from hw.lib.fork import Fork
from hw.memsys.bus.cache import Cache
from hw.memsys.bus.cache_policy import CachePolicy
from hw.memsys.bus.cell_fetch import CellFetch
from hw.memsys.bus.patch_fetch import PatchFetch
from hw.memsys.patches.path_formats import BEATS, PathFormats, RequestKind
from hw.memsys.port.memory_formats import MemoryFormats
from hw.memsys.port.read_share import ReadShare

__all__ = ["READERS", "SystemBusInterface"]

# Readers of main memory: records of cells, lists, patches.
READERS = 3


class SystemBusInterface(wiring.Component):
    """Caches in front of main memory: one for parts of the cells' lists, one for patches.

    Requests for cells and for patches are independent; those of one kind are answered in order.

    ::

        i_request -+- cell cache  - CellFetch  -+- ReadShare - o_request
                   '- patch cache - PatchFetch -'
        o_reply    <- records, beat by beat

    The key of a part of a list is that of the cell with the number of the part above it.

    Parameters
    ----------
    config
        The configuration.
    policies
        Those that are built; all by default.

    Members
    -------
    i_invalidate : In, stream of `CachePolicy`
        Empties both caches and sets the policy. Accepted when no request is in flight; no request is accepted before
        the first one.
    i_request : In, stream of `PathFormats.bus_request`
        Requests of all clusters.
    o_reply : Out, two streams of `PathFormats.bus_reply`
        Replies for cells and for patches.
    scene : In(PathFormats.scene)
        Numbers of the scene. Stable while requests are in flight.
    bases : In(PathFormats.bases)
        Addresses of its tables, likewise.
    o_request : Out, stream of `MemoryFormats.request`
        `MainMemoryPort`'s ``i_read``, with a tag of `READERS`.
    i_reply : In, stream of `MemoryFormats.reply`
        Its ``o_read``.
    cell_hits, cell_misses, patch_hits, patch_misses : Out(32)
        Since the last invalidation.

    Timing
    ------
    Latency: ``9`` cycles of a hit, 7 under ``LFU``. A cell takes as many cycles as its part has entries, at least one;
    a patch 5; both at the same time. Stalls with ``o_reply``, and while ``cache_fetches`` of a kind are in flight.

    Golden counterpart: `golden.engine.memsys.bus.cache.Cache`. Source: Shen 1993, section 5.3.7.
    """

    def __init__(self, *, config: Config, policies: tuple[CachePolicy, ...] = tuple(CachePolicy)):
        formats, memory, memsys = PathFormats(config), MemoryFormats(config), config.memsys
        self._config, self._formats = config, formats
        given = {"config": config, "tag": formats.cluster, "policies": policies}
        self._caches = (
            Cache(formats.cell_beat, beats=memsys.reply_ids, lines=memsys.cell_lines, key=formats.cell_key, **given),
            Cache(formats.beat_bits, beats=BEATS, lines=memsys.patch_lines, key=Formats(config).patch, **given))
        self._fetches = CellFetch(config=config), PatchFetch(config=config)
        replies = stream.Signature(formats.bus_reply)
        super().__init__({
            "i_invalidate": In(stream.Signature(CachePolicy)), "i_request": In(stream.Signature(formats.bus_request)),
            "o_reply": Out(replies).array(2), "scene": In(formats.scene), "bases": In(formats.bases),
            "o_request": Out(stream.Signature(memory.request(range(READERS)))),
            "i_reply": In(stream.Signature(memory.reply(range(READERS)))),
            **{f"{kind}_{what}": Out(32) for kind in ("cell", "patch") for what in ("hits", "misses")}})
        self.latency = self._caches[0].latency

    def elaborate(self, platform):
        m = Module()
        m.submodules.invalidations = invalidations = Fork(CachePolicy, count=2)
        m.submodules.share = share = ReadShare(config=self._config, count=READERS)
        wiring.connect(m, wiring.flipped(self.i_invalidate), invalidations.i)
        wiring.connect(m, share.o_request, wiring.flipped(self.o_request))
        wiring.connect(m, wiring.flipped(self.i_reply), share.i_reply)
        cells, patches = self._fetches
        m.d.comb += [cells.scene.eq(self.scene), cells.cells_base.eq(self.bases.cells),
                     cells.lists_base.eq(self.bases.lists), patches.base.eq(self.bases.patches),
                     patches.count.eq(self.scene.patches)]
        for number, (request, reply) in enumerate([*zip(cells.o_request, cells.i_reply, strict=True),
                                                   (patches.o_request, patches.i_reply)]):
            wiring.connect(m, request, share.i_request[number])
            wiring.connect(m, share.o_reply[number], reply)
        for kind, cache, fetch, out, start in zip(
                RequestKind, self._caches, self._fetches, self.o_reply, invalidations.o, strict=True):
            name = kind.name.lower()
            m.submodules[f"{name}_cache"], m.submodules[f"{name}_fetch"] = cache, fetch
            wiring.connect(m, start, cache.i_invalidate)
            wiring.connect(m, cache.o_fetch, fetch.i)
            # Registered: fills pass through checks.
            m.d.sync += [cache.i_fill.valid.eq(fetch.o.valid), cache.i_fill.payload.eq(fetch.o.payload)]
            m.d.comb += [getattr(self, f"{name}_hits").eq(cache.hits), getattr(self, f"{name}_misses").eq(cache.misses)]
            request_payload = self.i_request.payload
            m.d.comb += [cache.i.payload.tag.eq(request_payload.source),
                         cache.i.payload.key.eq(request_payload.item.key)]
            with m.If(request_payload.item.kind == kind):
                m.d.comb += [cache.i.valid.eq(self.i_request.valid), self.i_request.ready.eq(cache.i.ready)]
            self._add_replies(m, kind, cache, out)
        return m

    def _add_replies(self, m, kind, cache, out):
        """A record, beat by beat."""
        found, reply = cache.o.payload, out.payload
        beats = self._config.memsys.reply_ids if kind is RequestKind.CELL else BEATS
        number, last = Signal(range(beats), name=f"{kind.name.lower()}_beat"), Signal(name=f"{kind.name.lower()}_last")
        record = Array(found.record[beat].as_value() if kind is RequestKind.CELL else found.record[beat]
                       for beat in range(beats))
        if kind is RequestKind.CELL:
            # The next beat is empty.
            ends = Array([*(~found.record[beat].is_id for beat in range(1, beats)), 1])[number]
        else:
            # Registered: it advances the whole cache.
            ends = Signal(name="patch_ends")
            with m.If(out.valid & out.ready):
                m.d.sync += ends.eq(number == beats - 2)
        m.d.comb += [
            last.eq(ends), out.valid.eq(cache.o.valid), cache.o.ready.eq(out.ready & last),
            reply.cluster.eq(found.tag), reply.kind.eq(kind), reply.last.eq(last), reply.error.eq(found.error),
            reply.hit.eq(found.hit)]
        if kind is RequestKind.CELL:
            # An error is one beat.
            shown = Signal(self._formats.cell_beat)
            m.d.comb += [shown.eq(record[number]), reply.data.eq(shown)]
            with m.If(found.error):
                m.d.comb += [last.eq(1), shown.is_id.eq(0)]
        else:
            m.d.comb += reply.data.eq(record[number])
        with m.If(out.valid & out.ready):
            m.d.sync += number.eq(Mux(last, 0, number + 1))
