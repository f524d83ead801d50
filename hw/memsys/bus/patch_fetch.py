"""Patch fetch: patches from main memory to the patch cache."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.lib.queue import Queue
from hw.memsys.bus.patch_decoder import PatchDecoder
from hw.memsys.load.image_layout import PATCH_WORDS, RECORD_BYTES, RegionNumber
from hw.memsys.patches.path_formats import PathFormats
from hw.memsys.port.memory_formats import MemoryFormats
from hw.memsys.port.word_reader import WordReader

__all__ = ["PatchFetch"]

RECORD_BITS = RECORD_BYTES[RegionNumber.PATCHES.value].bit_length() - 1


class PatchFetch(wiring.Component):
    """Reads the record of each patch and assembles its beats.

    A record of another patch is an error, and so is a patch that does not exist; for that no transaction is issued.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `PathFormats.patch_fetch`
        The patch cache's ``o_fetch``.
    o : Out, stream of `PathFormats.patch_fill`
        Its ``i_fill``. Always ready.
    base : In(address_bits)
        Address of the patches' records, a multiple of 64. Stable while patches are read, and so is ``count``.
    count : In(listed_bits)
        The number of patches.
    o_request : Out, stream of `MemoryFormats.request`
        `MainMemoryPort`'s ``i_read``.
    i_reply : In, stream of `MemoryFormats.reply`
        Its ``o_read``.

    Timing
    ------
    Latency: ``2`` cycles from a patch to its request, ``0`` from a word to its beat. A patch every 6 cycles; as many in
    flight as the cache has fetches.
    """

    latency = 2

    def __init__(self, *, config: Config):
        self._config, self._formats = config, PathFormats(config)
        memory, formats = MemoryFormats(config), self._formats
        super().__init__({
            "i": In(stream.Signature(formats.patch_fetch)),
            "o": Out(stream.Signature(formats.patch_fill, always_ready=True)),
            "base": In(config.memory.address_bits), "count": In(formats.listed_bits),
            "o_request": Out(stream.Signature(memory.request(0))), "i_reply": In(stream.Signature(memory.reply(0)))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.reader = reader = WordReader(config=self._config)
        wiring.connect(m, reader.o_request, wiring.flipped(self.o_request))
        wiring.connect(m, wiring.flipped(self.i_reply), reader.i_reply)
        # A patch that is requested now; those that have been requested or do not exist.
        fetch = self._formats.patch_fetch
        pending, known, given = Signal(), Signal(), Signal(fetch, reset_less=True)
        address = Signal(len(self.base), reset_less=True)
        m.submodules.fetches = fetches = Queue(StructLayout({"fetch": fetch, "known": 1}),
                                               depth=self._config.memsys.cache_fetches)
        accepts = Signal()
        m.d.comb += [
            reader.i.valid.eq(pending & known & fetches.i.ready), reader.i.payload.address.eq(address),
            reader.i.payload.length.eq(PATCH_WORDS - 1), accepts.eq(fetches.i.ready & (reader.i.ready | ~known)),
            fetches.i.valid.eq(pending & accepts), fetches.i.payload.fetch.eq(given), fetches.i.payload.known.eq(known),
            self.i.ready.eq(~pending | accepts)]
        with m.If(self.i.ready):
            m.d.sync += [pending.eq(self.i.valid), given.eq(self.i.payload), known.eq(self.i.payload.key < self.count),
                         address.eq(self.base + (self.i.payload.key << RECORD_BITS))]

        # A beat for each word but word 1.
        oldest, word, number, moves = fetches.o.payload, reader.o.payload, Signal(range(PATCH_WORDS)), Signal()
        m.submodules.decoder = decoder = PatchDecoder(config=self._config)
        is_head = number == 0
        m.d.comb += [
            moves.eq(fetches.o.valid & (reader.o.valid | ~oldest.known)),
            reader.o.ready.eq(fetches.o.valid & oldest.known), fetches.o.ready.eq(moves & (number == PATCH_WORDS - 1)),
            decoder.valid.eq(moves), decoder.word.eq(number), decoder.data.eq(word.data)]
        fill = self.o.payload
        m.d.comb += [
            self.o.valid.eq(moves & (number != 1)), fill.slot.eq(oldest.fetch.slot),
            fill.beat.eq(Mux(is_head, 0, decoder.index + 1)),
            fill.error.eq(~oldest.known | word.error | (is_head & (decoder.patch != oldest.fetch.key))),
            fill.data.eq(Mux(is_head, Cat(oldest.fetch.key, decoder.surface), decoder.vertex.as_value()))]
        with m.If(moves):
            m.d.sync += number.eq(Mux(number == PATCH_WORDS - 1, 0, number + 1))
        return m
