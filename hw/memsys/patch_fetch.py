"""Patch fetch: patches from main memory to the patch cache."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.formats import Formats
from hw.lib.queue import Queue
from hw.memsys.memory_formats import MemoryFormats
from hw.memsys.path_formats import BEATS, PathFormats
from hw.memsys.word_reader import WordReader

__all__ = ["PatchFetch"]

# Of a patch's record in a memory image the words that are read, and its bytes; a coordinate in it.
WORDS, RECORD_BITS, COORDINATE = 6, 6, 24


class PatchFetch(wiring.Component):
    """Reads the record of each patch and puts its beats together. A record that says that it is another patch, or a
    patch that there is not, is an error; of the latter memory is not asked.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i, o
        The patch cache's ``o_fetch`` and ``i_fill``.
    base, count
        Address of the patches' records, a multiple of 64, and how many there are. The same while patches are read.
    o_request, i_reply
        `MainMemoryPort`'s ``i_read`` and ``o_read``.

    Timing
    ------
    Latency: ``2`` cycles from a patch to its request, ``0`` from a word to its beat. A patch every 6 cycles; as many
    under way as the cache has fetches.
    """

    def __init__(self, *, config: Config):
        self._config, self._formats, self._icu = config, PathFormats(config), Formats(config)
        memory, fetches, icu = MemoryFormats(config), config.memsys.cache_fetches, self._icu
        self._fetch = StructLayout({"slot": range(fetches), "key": icu.patch})
        super().__init__({
            "i": In(stream.Signature(self._fetch)),
            "o": Out(stream.Signature(StructLayout({
                "slot": range(fetches), "beat": range(BEATS), "data": self._formats.beat_bits, "error": 1}),
                always_ready=True)),
            "base": In(config.memory.address_bits), "count": In(self._formats.listed_bits),
            "o_request": Out(stream.Signature(memory.request(0))), "i_reply": In(stream.Signature(memory.reply(0)))})
        self._reader = WordReader(config=config)
        self.latency = 2

    def elaborate(self, platform):
        m = Module()
        m.submodules.reader = reader = self._reader
        wiring.connect(m, reader.o_request, wiring.flipped(self.o_request))
        wiring.connect(m, wiring.flipped(self.i_reply), reader.i_reply)
        # One is being asked for; those that have been asked for, or are unknown.
        held, known = Signal(), Signal()
        fetch, address = Signal(self._fetch, reset_less=True), Signal(len(self.base), reset_less=True)
        m.submodules.asked = asked = Queue(StructLayout({"fetch": self._fetch, "known": 1}),
                                           depth=self._config.memsys.cache_fetches)
        goes = Signal()
        m.d.comb += [
            reader.i.valid.eq(held & known & asked.i.ready), reader.i.payload.address.eq(address),
            reader.i.payload.length.eq(WORDS - 1), goes.eq(asked.i.ready & (reader.i.ready | ~known)),
            asked.i.valid.eq(held & goes), asked.i.payload.fetch.eq(fetch), asked.i.payload.known.eq(known),
            self.i.ready.eq(~held | goes)]
        with m.If(self.i.ready):
            m.d.sync += [held.eq(self.i.valid), fetch.eq(self.i.payload), known.eq(self.i.payload.key < self.count),
                         address.eq(self.base + (self.i.payload.key << RECORD_BITS))]

        # Words: id and surface, the top bytes of all beats, the low bits of each vertex.
        first, word, number = asked.o.payload, reader.o.payload, Signal(range(WORDS))
        tops, comes, vertex = Signal(64, reset_less=True), Signal(), Signal(range(BEATS - 1))
        width = self._icu.scene.width
        m.d.comb += [
            comes.eq(asked.o.valid & (reader.o.valid | ~first.known)), reader.o.ready.eq(asked.o.valid & first.known),
            asked.o.ready.eq(comes & (number == WORDS - 1)), vertex.eq(number - 2)]
        whole = Cat(word.data, tops.word_select(vertex + 1, 8))
        other = (number == 0) & (word.data[:32] != first.fetch.key)
        fill = self.o.payload
        m.d.comb += [
            self.o.valid.eq(comes & (number != 1)), fill.slot.eq(first.fetch.slot),
            fill.beat.eq(Mux(number == 0, 0, vertex + 1)), fill.error.eq(~first.known | word.error | other)]
        with m.If(number == 0):
            m.d.comb += fill.data.eq(Cat(first.fetch.key, word.data[32:]))
        with m.Else():
            m.d.comb += fill.data.eq(Cat(whole.word_select(axis, COORDINATE)[:width] for axis in range(3)))
        with m.If(comes):
            m.d.sync += number.eq(Mux(number == WORDS - 1, 0, number + 1))
            with m.If(number == 1):
                m.d.sync += tops.eq(word.data)
        return m
