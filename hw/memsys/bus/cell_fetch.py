"""Cell fetch: patch lists from main memory to the cell cache."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.lib.checks import claim
from hw.lib.queue import Queue
from hw.memsys.patches.path_formats import WORD, PathFormats
from hw.memsys.port.memory_formats import MemoryFormats
from hw.memsys.port.word_reader import WordReader

__all__ = ["CellFetch"]

# Logarithms of the bytes of a cell's record and of an entry of a list.
CELL_BITS, ENTRY_BITS = 3, 2


class CellFetch(wiring.Component):
    """Reads the record of each cell, then the entries of the requested part of its list.

    A list that is not within the patch lists is an error, and so is a cell or a part that does not exist, or the last
    part that can be named of a list that has more; for these no transaction is issued.

    A record is accepted whether or not the lists of those before it have been requested: no reply waits for a request.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `PathFormats.cell_fetch`
        The cell cache's ``o_fetch``.
    o : Out, stream of `PathFormats.cell_fill`
        Its ``i_fill``. Always ready.
    cells_base, lists_base : In(address_bits)
        Addresses of the cells' records and of the entries of all lists, multiples of 64. Stable while cells are read.
    scene : In(PathFormats.scene)
        Numbers of the scene. Stable while cells are read.
    o_request : Out, two streams of `MemoryFormats.request`
        `MainMemoryPort`'s ``i_read``, for records and for lists.
    i_reply : In, two streams of `MemoryFormats.reply`
        Its ``o_read``.

    Timing
    ------
    Latency: ``2`` cycles from a cell to its first request, ``5`` from its record to the request for the list, ``0``
    from an entry to its beat. A part every ``reply_ids`` cycles; as many in flight as the cache has fetches.
    """

    def __init__(self, *, config: Config):
        self._config, self._formats = config, PathFormats(config)
        formats, memory = self._formats, MemoryFormats(config)
        self._ids = config.memsys.reply_ids
        self._readers = [WordReader(config=config) for _ in range(2)]
        super().__init__({
            "i": In(stream.Signature(formats.cell_fetch)),
            "o": Out(stream.Signature(formats.cell_fill, always_ready=True)),
            "cells_base": In(config.memory.address_bits), "lists_base": In(config.memory.address_bits),
            "scene": In(formats.scene), "o_request": Out(stream.Signature(memory.request(0))).array(2),
            "i_reply": In(stream.Signature(memory.reply(0))).array(2)})
        self.latency = 2

    def elaborate(self, platform):
        m = Module()
        for name, reader, request, reply in zip(("records", "lists"), self._readers, self.o_request, self.i_reply,
                                                strict=True):
            m.submodules[name] = reader
            wiring.connect(m, reader.o_request, wiring.flipped(request))
            wiring.connect(m, wiring.flipped(reply), reader.i_reply)
        fetches = self._config.memsys.cache_fetches
        m.submodules.fetches = queue = Queue(StructLayout({"fetch": self._formats.cell_fetch, "known": 1}),
                                             depth=fetches)
        # Parts with outstanding entries: how many, and whether another part follows.
        part = StructLayout({"slot": range(fetches), "count": range(self._ids + 1), "more": 1, "error": 1})
        m.submodules.parts = parts = Queue(part, depth=fetches)
        # Lists to request: each has a part, so there is an entry for it.
        lists = self._readers[1]
        m.submodules.extents = extents = Queue(lists.i.payload.shape(), depth=fetches)
        wiring.connect(m, extents.o, lists.i)
        claim(m, ~extents.i.valid | extents.i.ready, "a list to request has an entry")
        self._add_records(m, queue)
        self._add_lists(m, queue, parts, extents.i)
        self._add_fills(m, parts)
        return m

    def _add_records(self, m, queue):
        """Requests for records."""
        reader, pending, known, accepts = self._readers[0], Signal(), Signal(), Signal()
        fetch = Signal(self._formats.cell_fetch, reset_less=True)
        address = Signal(len(self.cells_base), reset_less=True)
        cell = self.i.payload.key.cell
        m.d.comb += [
            reader.i.valid.eq(pending & known & queue.i.ready), reader.i.payload.address.eq(address),
            accepts.eq(queue.i.ready & (reader.i.ready | ~known)), queue.i.valid.eq(pending & accepts),
            queue.i.payload.fetch.eq(fetch), queue.i.payload.known.eq(known), self.i.ready.eq(~pending | accepts)]
        with m.If(self.i.ready):
            m.d.sync += [pending.eq(self.i.valid), fetch.eq(self.i.payload), known.eq(cell < self.scene.cells),
                         address.eq(self.cells_base + (cell << CELL_BITS))]

    def _add_lists(self, m, queue, parts, extents):
        """Checks the list of a record, and locates the part and counts its entries."""
        records, part, extent = self._readers[0], parts.i.payload, extents.payload
        oldest, word = queue.o.payload, records.o.payload
        pointer, count, before = (Signal(WORD, reset_less=True, name=name) for name in ("pointer", "count", "before"))
        end, left = Signal(WORD + 1, reset_less=True), Signal(WORD + 1, reset_less=True)
        failed, wrong, address = Signal(), Signal(), Signal(len(self.lists_base), reset_less=True)
        with m.FSM():
            with m.State("Read a record"), m.If(queue.o.valid & (records.o.valid | ~oldest.known)):
                m.d.comb += records.o.ready.eq(oldest.known)
                m.d.sync += [pointer.eq(word.data[:WORD]), count.eq(word.data[WORD:]),
                             before.eq(oldest.fetch.key.part << self._ids.bit_length() - 1),
                             failed.eq(~oldest.known | word.error)]
                m.next = "Compare"
            with m.State("Compare"):
                m.d.sync += [end.eq(pointer + count), left.eq(count - before), pointer.eq(pointer + before)]
                m.next = "Locate"
            with m.State("Locate"):
                m.d.sync += [wrong.eq((end > self.scene.lists) | left[-1]),
                             address.eq(self.lists_base + (pointer << ENTRY_BITS))]
                m.next = "Count"
            with m.State("Count"):
                fits = left[:WORD] <= self._ids
                error = failed | wrong | (~fits & oldest.fetch.key.part.all())
                m.d.comb += [
                    parts.i.valid.eq(1), part.slot.eq(oldest.fetch.slot), part.error.eq(error),
                    part.count.eq(Mux(error, 0, Mux(fits, left, self._ids))), part.more.eq(~fits & ~error),
                    extents.valid.eq(parts.i.ready & (part.count != 0)), extent.address.eq(address),
                    extent.length.eq(part.count - 1), extent.narrow.eq(1)]
                with m.If(parts.i.ready):
                    m.d.comb += queue.o.ready.eq(1)
                    m.next = "Read a record"

    def _add_fills(self, m, parts):
        """Entries, and empty beats after them."""
        reader, part, number, moves = self._readers[1], parts.o.payload, Signal(range(self._ids)), Signal()
        is_id, fill, entry = Signal(), self.o.payload, Signal(WORD)
        unknown = 1 << self._formats.listed_bits - 1
        m.d.comb += [
            is_id.eq(number < part.count), moves.eq(parts.o.valid & (reader.o.valid | ~is_id)), self.o.valid.eq(moves),
            reader.o.ready.eq(parts.o.valid & is_id), parts.o.ready.eq(moves & (number == self._ids - 1)),
            entry.eq(reader.o.payload.data), fill.slot.eq(part.slot), fill.beat.eq(number), fill.data.is_id.eq(is_id),
            fill.data.more.eq(part.more),
            fill.data.number.eq(Mux(entry < self.scene.patches, entry, unknown)),
            fill.error.eq(part.error | (is_id & reader.o.payload.error))]
        with m.If(moves):
            m.d.sync += number.eq(number + 1)
