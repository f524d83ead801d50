"""Word reader: an extent of memory as words."""

from amaranth.hdl import Cat, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.lib.queue import Queue
from hw.memsys.port.memory_formats import LENGTH_BITS, MemoryFormats

__all__ = ["WordReader"]


class WordReader(wiring.Component):
    """Reads consecutive words of 64 or of 32 bits. The first one may be any word of a beat.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `MemoryFormats.read_extent`
        Extents; the address is a multiple of a word.
    o : Out, stream of `MemoryFormats.word`
        The words of each extent in order.
    o_request : Out, stream of `MemoryFormats.request`
        `MainMemoryPort`'s ``i_read``.
    i_reply : In, stream of `MemoryFormats.reply`
        Its ``o_read``.

    Timing
    ------
    Latency: ``2`` cycles from an extent to its first request, ``0`` from a reply to a word. One word per cycle, without
    a gap between extents of more than a few words; stalls with ``o``; as many extents in flight as the port has bursts.
    """

    latency = 2

    def __init__(self, *, config: Config):
        self._config, self._formats = config, MemoryFormats(config)
        formats = self._formats
        super().__init__({
            "i": In(stream.Signature(formats.read_extent)), "o": Out(stream.Signature(formats.word)),
            "o_request": Out(stream.Signature(formats.request(0))), "i_reply": In(stream.Signature(formats.reply(0)))})

    def elaborate(self, platform):
        m = Module()
        memory, formats = self._config.memory, self._formats
        given, low = self.i.payload, formats.low_bits
        # The index of a half word, of 32 bits, in its beat.
        half_bits = low - 2
        half = given.address[2:low]
        m.submodules.extents = extents = Queue(
            StructLayout({"half": half_bits, "length": LENGTH_BITS, "narrow": 1}), depth=max(2, memory.outstanding))
        m.d.comb += [extents.i.payload.half.eq(half), extents.i.payload.length.eq(given.length),
                     extents.i.payload.narrow.eq(given.narrow)]

        # Requests of the greatest length, then the rest. ``left``: beats that are still to be requested, less one.
        counted, requests = Signal(), Signal()
        beat, left = Signal(formats.beat_bits + 1, reset_less=True), Signal(LENGTH_BITS + 1, reset_less=True)
        halves = Signal(LENGTH_BITS + 2)
        m.d.comb += [
            halves.eq(Mux(given.narrow, given.length, Cat(Const(1, 1), given.length)) + half),
            self.i.ready.eq(~counted & extents.i.ready), extents.i.valid.eq(self.i.valid & ~counted)]
        many = left[memory.length_bits:]
        request = self.o_request
        m.d.comb += [
            request.valid.eq(counted), requests.eq(request.valid & request.ready),
            request.payload.address.eq(Cat(Const(0, low), beat)),
            request.payload.length.eq(Mux(many == 0, left[:memory.length_bits], Const(-1, memory.length_bits)))]
        with m.If(self.i.valid & self.i.ready):
            m.d.sync += [counted.eq(1), beat.eq(given.address[low:]), left.eq(halves >> half_bits)]
        with m.If(requests):
            m.d.sync += [beat.eq(beat + (1 << memory.length_bits)), many.eq(many - 1), counted.eq(many != 0)]

        # Words out of beats.
        extent, begun = extents.o.payload, Signal()
        at, to_come = Signal(half_bits), Signal(LENGTH_BITS)
        here, rest = Signal(half_bits), Signal(LENGTH_BITS)
        lanes = self.i_reply.payload.data
        single = lanes.word_select(here, 32)
        double = lanes.word_select(here[1:], 64) if half_bits > 1 else lanes
        # The last word of its beat.
        full = (here | ~extent.narrow) == (1 << half_bits) - 1
        m.d.comb += [
            here.eq(Mux(begun, at, extent.half)), rest.eq(Mux(begun, to_come, extent.length)),
            self.o.valid.eq(self.i_reply.valid & extents.o.valid), self.o.payload.last.eq(rest == 0),
            self.o.payload.data.eq(Mux(extent.narrow, single, double)),
            self.o.payload.error.eq(self.i_reply.payload.error),
            self.i_reply.ready.eq(self.o.ready & extents.o.valid & (full | self.o.payload.last)),
            extents.o.ready.eq(self.o.valid & self.o.ready & self.o.payload.last)]
        with m.If(self.o.valid & self.o.ready):
            m.d.sync += [begun.eq(~self.o.payload.last), at.eq(here + Mux(extent.narrow, 1, 2)),
                         to_come.eq(rest - 1)]
        return m
