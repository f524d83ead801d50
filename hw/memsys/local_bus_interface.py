"""Local bus interface: a cluster's requests for cells and patches, and the replies."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import data, stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.formats import Formats
from hw.lib.arbiter import Arbiter
from hw.lib.credit_gate import CreditGate
from hw.lib.queue import Queue
from hw.memsys.path_formats import BEATS, PathFormats, RequestKind

__all__ = ["LocalBusInterface"]

VERTICES = BEATS - 1


class LocalBusInterface(wiring.Component):
    """Asks the bus for what is nowhere in the cluster. Each request leaves with room for its whole reply, so replies
    are always taken.

    A list of more than ``reply_ids`` entries comes in parts: the next one is asked for when the last entry of a part
    has gone on.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i_cell, i_patch
        A cell and a patch to ask for.
    o_request
        `PathFormats.request`.
    i_reply
        Beats for this cluster, `PathFormats.bus_reply`; replies of a kind in the order of the requests. Always ready.
    o_listed
        `PathFormats.cell_beat` with ``last`` of its cell, which need not be an id.
    o_vertex
        `Formats.patch_vertex`; four vertices of a patch follow each other.
    lost_cell, lost_patch, number
        A reply was an error, and of which cell or patch, in the cycle after its end; the cell's entries, if there were
        any, have gone on, the patch has no vertices. Of two in the same cycle that of the cell.
    hits, misses
        Replies to requests for patches, by where they were.

    Timing
    ------
    Latency: ``1`` cycle from a cell or a patch to its request, ``1`` from a beat to an entry or a vertex. One beat,
    one entry and one vertex per cycle; stalls while ``bus_requests`` cells, or patches, have not gone on in full.

    Source: Shen 1993, section 5.3.6.1.
    """

    latency = 1

    def __init__(self, *, config: Config):
        self._config, self._formats, self._icu = config, PathFormats(config), Formats(config)
        formats, icu = self._formats, self._icu
        self._listed = StructLayout({"item": formats.cell_beat, "last": 1})
        super().__init__({
            "i_cell": In(stream.Signature(formats.cell_bits)), "i_patch": In(stream.Signature(icu.patch)),
            "o_request": Out(stream.Signature(formats.request)),
            "i_reply": In(stream.Signature(formats.bus_reply, always_ready=True)),
            "o_listed": Out(stream.Signature(self._listed)), "o_vertex": Out(stream.Signature(icu.patch_vertex)),
            "lost_cell": Out(1), "lost_patch": Out(1), "number": Out(24), "hits": Out(32), "misses": Out(32)})

    def elaborate(self, platform):
        m = Module()
        requests = self._config.memsys.bus_requests
        m.submodules.requests = requests_out = Arbiter(self._formats.request, count=2)
        m.d.comb += [self.o_request.valid.eq(requests_out.o.valid), requests_out.o.ready.eq(self.o_request.ready),
                     self.o_request.payload.eq(requests_out.o.payload.item)]
        cells, patches = requests_out.i
        self._add_cells(m, cells, requests)
        self._add_patches(m, patches, requests)
        return m

    def _add_cells(self, m, out, requests):
        formats, ids = self._formats, self._config.memsys.reply_ids
        m.submodules.cell_gate = gate = CreditGate(formats.cell_bits, credits=requests)
        # Parts that have been asked for and have not gone on in full, oldest first, and those to be asked for.
        m.submodules.asked = asked = Queue(formats.cell_key, depth=requests)
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
            asked.i.valid.eq(out.valid & out.ready), asked.i.payload.eq(key)]
        m.d.sync += offers_cell.eq(out.valid & ~out.ready & ~is_further)

        place = StructLayout({"item": formats.cell_beat, "ends": 1, "error": 1})
        m.submodules.ids = room = Queue(place, depth=ids * requests)
        came, reply = data.View(formats.cell_beat, self.i_reply.payload.data[:formats.cell_beat.size]), self.i_reply
        m.d.comb += [
            room.i.valid.eq(reply.valid & (reply.payload.kind == RequestKind.CELL)), room.i.payload.item.eq(came),
            room.i.payload.ends.eq(reply.payload.last), room.i.payload.error.eq(reply.payload.error)]
        first, more, goes, ends = room.o.payload, Signal(), Signal(), Signal()
        m.d.comb += [
            more.eq(first.ends & first.item.more & ~first.error),
            self.o_listed.valid.eq(room.o.valid), room.o.ready.eq(self.o_listed.ready),
            self.o_listed.payload.item.eq(first.item),
            self.o_listed.payload.last.eq(first.ends & ~more), goes.eq(room.o.valid & room.o.ready),
            ends.eq(goes & first.ends), asked.o.ready.eq(ends), further.i.valid.eq(ends & more),
            further.i.payload.cell.eq(asked.o.payload.cell), further.i.payload.part.eq(asked.o.payload.part + 1),
            gate.i_return.valid.eq(ends & ~more)]
        self._loses = Signal()
        m.d.comb += self._loses.eq(ends & first.error)
        m.d.sync += self.lost_cell.eq(self._loses)
        with m.If(self._loses):
            m.d.sync += self.number.eq(asked.o.payload.cell)

    def _add_patches(self, m, out, requests):
        formats, icu = self._formats, self._icu
        m.submodules.patch_gate = gate = CreditGate(icu.patch, credits=requests)
        wiring.connect(m, wiring.flipped(self.i_patch), gate.i)
        m.d.comb += [
            out.valid.eq(gate.o.valid), gate.o.ready.eq(out.ready), out.payload.kind.eq(RequestKind.PATCH),
            out.payload.key.eq(gate.o.payload)]
        # The head of a reply goes along with its vertices.
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
        m.submodules.vertices = room = Queue(StructLayout({"vertex": icu.patch_vertex, "error": 1}),
                                             depth=VERTICES * requests)
        came, first = room.i.payload, room.o.payload
        index, goes, ends = Signal(range(VERTICES)), Signal(), Signal()
        m.d.comb += [
            room.i.valid.eq(mine & (beat != 0)), came.vertex.patch.eq(head.head.patch),
            came.vertex.surface.eq(head.head.surface),
            Cat(came.vertex.vertex[axis] for axis in range(3)).eq(reply.payload.data), came.error.eq(head.error),
            self.o_vertex.payload.eq(first.vertex), self.o_vertex.valid.eq(room.o.valid & ~first.error),
            room.o.ready.eq(self.o_vertex.ready | first.error), goes.eq(room.o.valid & room.o.ready),
            ends.eq(goes & (index == VERTICES - 1)), gate.i_return.valid.eq(ends)]
        m.d.sync += self.lost_patch.eq(ends & first.error)
        with m.If(goes):
            m.d.sync += index.eq(index + 1)
        with m.If(~self._loses):
            m.d.sync += self.number.eq(first.vertex.patch)
