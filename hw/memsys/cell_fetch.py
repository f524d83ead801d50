"""Cell fetch: the patch lists of cells from main memory to the cell cache."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.lib.queue import Queue
from hw.memsys.memory_formats import MemoryFormats
from hw.memsys.path_formats import WORD, PathFormats
from hw.memsys.word_reader import WordReader

__all__ = ["CellFetch"]

# Logarithms of the bytes of a cell's record and of an entry of a list.
CELL_BITS, ENTRY_BITS = 3, 2


class CellFetch(wiring.Component):
    """Reads the record of each cell, and then the entries of the part of its list that is asked for.

    A list that is not within the patch lists is an error, as is a cell or a part that there is not; of these memory
    is not asked.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i, o
        The cell cache's ``o_fetch`` and ``i_fill``.
    cells_base, lists_base
        Addresses of the cells' records and of the entries of all lists, multiples of 64. The same while cells are
        read, and so is
    scene
        `PathFormats.scene`.
    o_request, i_reply
        Arrays of two: `MainMemoryPort`'s ``i_read`` and ``o_read`` for records and for lists.

    Timing
    ------
    Latency: ``2`` cycles from a cell to its first request, ``5`` from its record to the request for the list, ``0``
    from an entry to its beat. A part every ``reply_ids`` cycles; as many under way as the cache has fetches.
    """

    def __init__(self, *, config: Config):
        self._config, self._formats = config, PathFormats(config)
        formats, memory, fetches = self._formats, MemoryFormats(config), config.memsys.cache_fetches
        self._ids = config.memsys.reply_ids
        self._fetch = StructLayout({"slot": range(fetches), "key": formats.cell_key})
        self._readers = [WordReader(config=config) for _ in range(2)]
        super().__init__({
            "i": In(stream.Signature(self._fetch)),
            "o": Out(stream.Signature(StructLayout({
                "slot": range(fetches), "beat": range(self._ids), "data": formats.cell_beat, "error": 1}),
                always_ready=True)),
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
        m.submodules.asked = asked = Queue(StructLayout({"fetch": self._fetch, "known": 1}), depth=fetches)
        # Parts whose entries are awaited: how many, and whether there are more after them.
        part = StructLayout({"slot": range(fetches), "count": range(self._ids + 1), "more": 1, "error": 1})
        m.submodules.parts = parts = Queue(part, depth=fetches)
        self._add_records(m, asked)
        self._add_lists(m, asked, parts)
        self._add_fills(m, parts)
        return m

    def _add_records(self, m, asked):
        """Requests for records."""
        reader, held, known, goes = self._readers[0], Signal(), Signal(), Signal()
        fetch, address = Signal(self._fetch, reset_less=True), Signal(len(self.cells_base), reset_less=True)
        cell = self.i.payload.key.cell
        m.d.comb += [
            reader.i.valid.eq(held & known & asked.i.ready), reader.i.payload.address.eq(address),
            goes.eq(asked.i.ready & (reader.i.ready | ~known)), asked.i.valid.eq(held & goes),
            asked.i.payload.fetch.eq(fetch), asked.i.payload.known.eq(known), self.i.ready.eq(~held | goes)]
        with m.If(self.i.ready):
            m.d.sync += [held.eq(self.i.valid), fetch.eq(self.i.payload), known.eq(cell < self.scene.cells),
                         address.eq(self.cells_base + (cell << CELL_BITS))]

    def _add_lists(self, m, asked, parts):
        """A record: is its list one, where does the part begin, and how many entries has it?"""
        records, lists = self._readers
        first, word = asked.o.payload, records.o.payload
        pointer, count, before = (Signal(WORD, reset_less=True, name=name) for name in ("pointer", "count", "before"))
        end, left = Signal(WORD + 1, reset_less=True), Signal(WORD + 1, reset_less=True)
        failed, wrong = Signal(), Signal()
        part, address = Signal(parts.i.payload.shape(), reset_less=True), Signal(len(self.lists_base), reset_less=True)
        with m.FSM():
            with m.State("Take a record"), m.If(asked.o.valid & (records.o.valid | ~first.known)):
                m.d.comb += records.o.ready.eq(first.known)
                m.d.sync += [pointer.eq(word.data[:WORD]), count.eq(word.data[WORD:]),
                             before.eq(first.fetch.key.part << self._ids.bit_length() - 1),
                             failed.eq(~first.known | word.error)]
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
                m.d.sync += [part.slot.eq(first.fetch.slot), part.error.eq(failed | wrong),
                             part.count.eq(Mux(failed | wrong, 0, Mux(fits, left, self._ids))),
                             part.more.eq(~fits & ~(failed | wrong))]
                m.next = "Ask"
            with m.State("Ask"):
                asks = part.count != 0
                m.d.comb += [
                    lists.i.valid.eq(asks & parts.i.ready), lists.i.payload.address.eq(address),
                    lists.i.payload.length.eq(part.count - 1), lists.i.payload.narrow.eq(1),
                    parts.i.valid.eq(~asks | lists.i.ready), parts.i.payload.eq(part)]
                with m.If(parts.i.valid & parts.i.ready):
                    m.d.comb += asked.o.ready.eq(1)
                    m.next = "Take a record"

    def _add_fills(self, m, parts):
        """Entries, and empty places behind them."""
        reader, part, number, comes = self._readers[1], parts.o.payload, Signal(range(self._ids)), Signal()
        is_id, fill, entry = Signal(), self.o.payload, Signal(WORD)
        unknown = 1 << self._formats.listed_bits - 1
        m.d.comb += [
            is_id.eq(number < part.count), comes.eq(parts.o.valid & (reader.o.valid | ~is_id)), self.o.valid.eq(comes),
            reader.o.ready.eq(parts.o.valid & is_id), parts.o.ready.eq(comes & (number == self._ids - 1)),
            entry.eq(reader.o.payload.data), fill.slot.eq(part.slot), fill.beat.eq(number), fill.data.is_id.eq(is_id),
            fill.data.more.eq(part.more),
            fill.data.number.eq(Mux(entry < self.scene.patches, entry, unknown)),
            fill.error.eq(part.error | (is_id & reader.o.payload.error))]
        with m.If(comes):
            m.d.sync += number.eq(number + 1)
