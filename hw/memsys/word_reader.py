"""Word reader: any stretch of memory as words, one after the other."""

from amaranth.hdl import Cat, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.lib.queue import Queue
from hw.memsys.memory_formats import MemoryFormats

__all__ = ["WordReader"]

LENGTH_BITS = 36


class WordReader(wiring.Component):
    """Words of 64 bits, or of 32, from an address on, wherever in a beat that is.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i
        ``address`` (a multiple of a word), ``length`` in words after the first one, ``narrow`` (words of 32 bits).
    o
        ``data``, ``last``, and ``error``, with which the data mean nothing.
    o_request, i_reply
        `MainMemoryPort`'s ``i_read`` and ``o_read``.

    Timing
    ------
    Latency: ``2`` cycles from a stretch to its first request, ``0`` from a reply to a word. One word per cycle, without
    a gap between stretches of more than a few words; stalls with ``o``; as many stretches under way as the port has
    bursts.
    """

    def __init__(self, *, config: Config):
        self._config, self._formats = config, MemoryFormats(config)
        super().__init__({
            "i": In(stream.Signature(StructLayout({"address": config.memory.address_bits, "length": LENGTH_BITS,
                                                   "narrow": 1}))),
            "o": Out(stream.Signature(StructLayout({"data": 64, "last": 1, "error": 1}))),
            "o_request": Out(stream.Signature(self._formats.request(0))),
            "i_reply": In(stream.Signature(self._formats.reply(0)))})
        self.latency = 2

    def elaborate(self, platform):
        m = Module()
        memory, formats = self._config.memory, self._formats
        given, low = self.i.payload, formats.low_bits
        # A half is 32 bits. Its place in a beat:
        place_bits = low - 2
        place = given.address[2:low]
        m.submodules.stretches = stretches = Queue(
            StructLayout({"place": place_bits, "length": LENGTH_BITS, "narrow": 1}), depth=max(2, memory.outstanding))
        m.d.comb += [stretches.i.payload.place.eq(place), stretches.i.payload.length.eq(given.length),
                     stretches.i.payload.narrow.eq(given.narrow)]

        # Requests, the longest ones first. Beats that are still to be asked for, but one: so many longest requests, and
        # what is left.
        counted, asks = Signal(), Signal()
        beat, left = Signal(formats.beat_bits, reset_less=True), Signal(LENGTH_BITS + 1, reset_less=True)
        halves = Signal(LENGTH_BITS + 2)
        m.d.comb += [
            halves.eq(Mux(given.narrow, given.length, Cat(Const(1, 1), given.length)) + place),
            self.i.ready.eq(~counted & stretches.i.ready), stretches.i.valid.eq(self.i.valid & ~counted)]
        many = left[memory.length_bits:]
        request = self.o_request
        m.d.comb += [
            request.valid.eq(counted), asks.eq(request.valid & request.ready),
            request.payload.address.eq(Cat(Const(0, low), beat)),
            request.payload.length.eq(Mux(many == 0, left[:memory.length_bits], Const(-1, memory.length_bits)))]
        with m.If(self.i.valid & self.i.ready):
            m.d.sync += [counted.eq(1), beat.eq(given.address[low:]), left.eq(halves >> place_bits)]
        with m.If(asks):
            m.d.sync += [beat.eq(beat + (1 << memory.length_bits)), many.eq(many - 1), counted.eq(many != 0)]

        # Words out of beats.
        stretch, begun = stretches.o.payload, Signal()
        at, to_come = Signal(place_bits), Signal(LENGTH_BITS)
        here, rest = Signal(place_bits), Signal(LENGTH_BITS)
        lanes = self.i_reply.payload.data
        single = lanes.word_select(here, 32)
        double = lanes.word_select(here[1:], 64) if place_bits > 1 else lanes
        # The last word of its beat.
        full = (here | ~stretch.narrow) == (1 << place_bits) - 1
        m.d.comb += [
            here.eq(Mux(begun, at, stretch.place)), rest.eq(Mux(begun, to_come, stretch.length)),
            self.o.valid.eq(self.i_reply.valid & stretches.o.valid), self.o.payload.last.eq(rest == 0),
            self.o.payload.data.eq(Mux(stretch.narrow, single, double)),
            self.o.payload.error.eq(self.i_reply.payload.error),
            self.i_reply.ready.eq(self.o.ready & stretches.o.valid & (full | self.o.payload.last)),
            stretches.o.ready.eq(self.o.valid & self.o.ready & self.o.payload.last)]
        with m.If(self.o.valid & self.o.ready):
            m.d.sync += [begun.eq(~self.o.payload.last), at.eq(here + Mux(stretch.narrow, 1, 2)),
                         to_come.eq(rest - 1)]
        return m
