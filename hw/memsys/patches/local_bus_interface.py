"""Local bus interface: a cluster's requests for cells and patches, and the replies."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import data, stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.formats import VERTICES, Formats
from hw.lib.arbiter import Arbiter
from hw.lib.checks import claim
from hw.lib.credit_gate import CreditGate
from hw.lib.queue import Queue
from hw.memsys.patches.path_formats import BEATS, PathFormats, RequestKind

__all__ = ["LocalBusInterface"]


class LocalBusInterface(wiring.Component):
    """Requests cells and patches that are not in the cluster. Each request reserves the entries of its whole reply, so
    replies are always accepted.

    A list of more than ``reply_ids`` entries comes in parts: the next one is requested when the last entry of a part
    has left.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i_cell : In, stream of the number of a cell
        Cells to request.
    i_patch : In, stream of a patch id
        Patches to request.
    o_request : Out, stream of `PathFormats.request`
        Requests.
    i_reply : In, stream of `PathFormats.bus_reply`
        Beats for this cluster; replies of a kind in the order of the requests. Always ready.
    o_listed : Out, stream of ``item`` (`PathFormats.cell_beat`), ``last``
        Entries; the ``last`` one of its cell need not be an id.
    o_vertex : Out, stream of `Formats.patch_vertex`
        The four vertices of a patch, one after the other.
    lost_cell, lost_patch : Out(1)
        A reply was an error, in the cycle after its end. The entries of the cell have left, the patch has no vertices.
    cell : Out(cell_bits)
        The cell, at ``lost_cell``.
    patch : Out(patch_bits)
        The patch, at ``lost_patch``.
    hits, misses : Out(32)
        Replies with patches from the cache, and from main memory.

    Timing
    ------
    Latency: ``1`` cycle from a cell or a patch to its request, ``1`` from a beat to an entry or a vertex. One beat, one
    entry and one vertex per cycle; stalls while ``bus_requests`` cells, or patches, are in flight.

    Source: Shen 1993, section 5.3.6.1.
    """

    latency = 1

    def __init__(self, *, config: Config):
        self._config, self._formats, self._icu = config, PathFormats(config), Formats(config)
        formats, icu = self._formats, self._icu
        # Cells and patches in flight; the memory system checks that none is left when a frustum begins.
        self.gates = [CreditGate(shape, credits=config.memsys.bus_requests)
                      for shape in (formats.cell_bits, icu.patch)]
        self._listed = StructLayout({"item": formats.cell_beat, "last": 1})
        super().__init__({
            "i_cell": In(stream.Signature(formats.cell_bits)), "i_patch": In(stream.Signature(icu.patch)),
            "o_request": Out(stream.Signature(formats.request)),
            "i_reply": In(stream.Signature(formats.bus_reply, always_ready=True)),
            "o_listed": Out(stream.Signature(self._listed)), "o_vertex": Out(stream.Signature(icu.patch_vertex)),
            "lost_cell": Out(1), "lost_patch": Out(1), "cell": Out(formats.cell_bits), "patch": Out(icu.patch),
            "hits": Out(32), "misses": Out(32)})

    def elaborate(self, platform):
        m = Module()
        requests = self._config.memsys.bus_requests
        m.submodules.requests = arbiter = Arbiter(self._formats.request, count=2)
        m.d.comb += [self.o_request.valid.eq(arbiter.o.valid), arbiter.o.ready.eq(self.o_request.ready),
                     self.o_request.payload.eq(arbiter.o.payload.item)]
        cells, patches = arbiter.i
        self._add_patches(m, patches, requests)
        self._add_cells(m, cells, requests)
        return m

    def _add_cells(self, m, out, requests):
        formats, ids = self._formats, self._config.memsys.reply_ids
        m.submodules.cell_gate = gate = self.gates[0]
        # Parts in flight, oldest first, and those that are still to be requested.
        m.submodules.requested = requested = Queue(formats.cell_key, depth=requests)
        m.submodules.further = further = Queue(formats.cell_key, depth=requests)
        wiring.connect(m, wiring.flipped(self.i_cell), gate.i)
        # Further parts come before other cells, but an offer of a cell stays until it is taken.
        key, is_further, offers_cell = Signal(formats.cell_key), Signal(), Signal()
        m.d.comb += [
            is_further.eq(further.o.valid & ~offers_cell),
            key.cell.eq(Mux(is_further, further.o.payload.cell, gate.o.payload)),
            key.part.eq(Mux(is_further, further.o.payload.part, 0)),
            out.valid.eq(further.o.valid | gate.o.valid), out.payload.kind.eq(RequestKind.CELL),
            out.payload.key.eq(key), further.o.ready.eq(out.ready & is_further),
            gate.o.ready.eq(out.ready & ~is_further),
            requested.i.valid.eq(out.valid & out.ready), requested.i.payload.eq(key)]
        m.d.sync += offers_cell.eq(out.valid & ~out.ready & ~is_further)

        entry = StructLayout({"item": formats.cell_beat, "ends": 1, "error": 1})
        m.submodules.ids = entries = Queue(entry, depth=ids * requests)
        beat, reply = data.View(formats.cell_beat, self.i_reply.payload.data[:formats.cell_beat.size]), self.i_reply
        m.d.comb += [
            entries.i.valid.eq(reply.valid & (reply.payload.kind == RequestKind.CELL)), entries.i.payload.item.eq(beat),
            entries.i.payload.ends.eq(reply.payload.last), entries.i.payload.error.eq(reply.payload.error)]
        claim(m, ~entries.i.valid | (entries.i.ready & requested.o.valid), "a cell's reply has been requested")
        claim(m, ~further.i.valid | further.i.ready, "a further part has an entry")
        claim(m, ~entries.i.valid | ~reply.payload.error | (reply.payload.last & ~beat.is_id), "an error is one beat")
        oldest, more, moves, ends = entries.o.payload, Signal(), Signal(), Signal()
        m.d.comb += [
            more.eq(oldest.ends & oldest.item.more & ~oldest.error),
            self.o_listed.valid.eq(entries.o.valid), entries.o.ready.eq(self.o_listed.ready),
            self.o_listed.payload.item.eq(oldest.item),
            self.o_listed.payload.last.eq(oldest.ends & ~more), moves.eq(entries.o.valid & entries.o.ready),
            ends.eq(moves & oldest.ends), requested.o.ready.eq(ends), further.i.valid.eq(ends & more),
            further.i.payload.cell.eq(requested.o.payload.cell),
            further.i.payload.part.eq(requested.o.payload.part + 1),
            gate.i_return.valid.eq(ends & ~more)]
        m.d.sync += [self.lost_cell.eq(ends & oldest.error), self.cell.eq(requested.o.payload.cell)]

    def _add_patches(self, m, out, requests):
        formats, icu = self._formats, self._icu
        m.submodules.patch_gate = gate = self.gates[1]
        wiring.connect(m, wiring.flipped(self.i_patch), gate.i)
        m.d.comb += [
            out.valid.eq(gate.o.valid), gate.o.ready.eq(out.ready), out.payload.kind.eq(RequestKind.PATCH),
            out.payload.key.eq(gate.o.payload)]
        # The head of a reply moves along with its vertices.
        reply, beat = self.i_reply, Signal(range(BEATS))
        head = Signal(StructLayout({"head": formats.patch_head, "error": 1}), reset_less=True)
        mine = Signal()
        m.d.comb += mine.eq(reply.valid & (reply.payload.kind == RequestKind.PATCH))
        with m.If(mine):
            m.d.sync += beat.eq(Mux(beat == BEATS - 1, 0, beat + 1))
            with m.If(beat == 0):
                m.d.sync += [head.head.eq(reply.payload.data), head.error.eq(reply.payload.error),
                             self.hits.eq(self.hits + reply.payload.hit),
                             self.misses.eq(self.misses + ~reply.payload.hit)]
        m.submodules.vertices = entries = Queue(StructLayout({"vertex": icu.patch_vertex, "error": 1}),
                                             depth=VERTICES * requests)
        claim(m, ~mine | (gate.level != 0), "a patch's reply has been requested")
        claim(m, ~entries.i.valid | entries.i.ready, "a patch's vertices have entries")
        claim(m, ~mine | (reply.payload.last == (beat == BEATS - 1)), "a patch has all its beats")
        given, oldest = entries.i.payload, entries.o.payload
        index, moves, ends = Signal(range(VERTICES)), Signal(), Signal()
        m.d.comb += [
            entries.i.valid.eq(mine & (beat != 0)), given.vertex.patch.eq(head.head.patch),
            given.vertex.surface.eq(head.head.surface),
            Cat(given.vertex.vertex[axis] for axis in range(3)).eq(reply.payload.data), given.error.eq(head.error),
            self.o_vertex.payload.eq(oldest.vertex), self.o_vertex.valid.eq(entries.o.valid & ~oldest.error),
            entries.o.ready.eq(self.o_vertex.ready | oldest.error), moves.eq(entries.o.valid & entries.o.ready),
            ends.eq(moves & (index == VERTICES - 1)), gate.i_return.valid.eq(ends)]
        m.d.sync += [self.lost_patch.eq(ends & oldest.error), self.patch.eq(oldest.vertex.patch)]
        with m.If(moves):
            m.d.sync += index.eq(index + 1)
