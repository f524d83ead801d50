"""Word writer: words one after the other to any stretch of memory."""

from amaranth.hdl import Cat, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.lib.queue import Queue
from hw.memsys.memory_formats import MemoryFormats

__all__ = ["WordWriter"]

LENGTH_BITS = 32
WORD_BYTES = 8


class WordWriter(wiring.Component):
    """Words of 64 bits, from an address on, wherever in a beat that is; nothing beside them is changed.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i
        ``address`` (a multiple of 8), ``length`` in words after the first one.
    i_word
        ``data``, and whether it ``counts``: another one takes a word's turn and leaves memory as it is.
    o_request, o_data
        `MainMemoryPort`'s ``i_write`` and ``i_write_data``.
    busy
        Requests or words of a stretch are still to come.

    Timing
    ------
    Latency: ``1`` cycle from a stretch to its first request, ``0`` from the last word of a beat to the beat. One word
    per cycle, without a gap between stretches of more than a few words; stalls with ``o_request`` and ``o_data``; two
    stretches under way.
    """

    def __init__(self, *, config: Config):
        self._config, self._formats = config, MemoryFormats(config)
        super().__init__({
            "i": In(stream.Signature(StructLayout({"address": config.memory.address_bits, "length": LENGTH_BITS}))),
            "i_word": In(stream.Signature(StructLayout({"data": 8 * WORD_BYTES, "counts": 1}))),
            "o_request": Out(stream.Signature(self._formats.request(0))),
            "o_data": Out(stream.Signature(self._formats.write_data)), "busy": Out(1)})
        self.latency = 1

    def elaborate(self, platform):
        m = Module()
        memory, low = self._config.memory, self._formats.low_bits
        given = self.i.payload
        # Of a word's address, its place in a beat: there are no bits of it where a beat is a word.
        place = given.address[3:low]
        m.submodules.stretches = stretches = Queue(
            StructLayout({"place": len(place), "length": LENGTH_BITS}), depth=2)
        m.d.comb += [stretches.i.payload.place.eq(place), stretches.i.payload.length.eq(given.length)]

        # Requests, the longest ones first. Beats that are still to be asked for, but one: so many longest requests, and
        # what is left.
        counted, asks = Signal(), Signal()
        beat, left = Signal(self._formats.beat_bits, reset_less=True), Signal(LENGTH_BITS + 1, reset_less=True)
        many = left[memory.length_bits:]
        request = self.o_request
        m.d.comb += [
            self.i.ready.eq(~counted & stretches.i.ready), stretches.i.valid.eq(self.i.valid & ~counted),
            request.valid.eq(counted), asks.eq(request.valid & request.ready),
            request.payload.address.eq(Cat(Const(0, low), beat)),
            request.payload.length.eq(Mux(many == 0, left[:memory.length_bits], Const(-1, memory.length_bits))),
            self.busy.eq(counted | stretches.o.valid)]
        with m.If(self.i.valid & self.i.ready):
            m.d.sync += [counted.eq(1), beat.eq(given.address[low:]), left.eq((given.length + place) >> len(place))]
        with m.If(asks):
            m.d.sync += [beat.eq(beat + (1 << memory.length_bits)), many.eq(many - 1), counted.eq(many != 0)]

        # Words into beats.
        stretch, word, begun = stretches.o.payload, self.i_word.payload, Signal()
        at, to_come = Signal(len(place)), Signal(LENGTH_BITS)
        here, rest = Signal(len(place)), Signal(LENGTH_BITS)
        kept, whole = (Signal(self._formats.write_data, name=name) for name in ("kept", "whole"))
        ends, full, takes = Signal(), Signal(), Signal()
        m.d.comb += [
            here.eq(Mux(begun, at, stretch.place)), rest.eq(Mux(begun, to_come, stretch.length)), ends.eq(rest == 0),
            full.eq(ends | here.all() if len(place) else 1), whole.eq(kept),
            whole.data.word_select(here, 8 * WORD_BYTES).eq(word.data),
            whole.strobe.word_select(here, WORD_BYTES).eq(word.counts.replicate(WORD_BYTES)),
            self.o_data.payload.eq(whole), self.o_data.valid.eq(self.i_word.valid & stretches.o.valid & full),
            self.i_word.ready.eq(stretches.o.valid & (self.o_data.ready | ~full)),
            takes.eq(self.i_word.valid & self.i_word.ready), stretches.o.ready.eq(takes & ends)]
        with m.If(takes):
            m.d.sync += [begun.eq(~ends), at.eq(here + 1), to_come.eq(rest - 1), kept.eq(whole)]
            with m.If(full):
                m.d.sync += kept.strobe.eq(0)
        return m
