"""Word writer: words to an extent of memory."""

from amaranth.hdl import Cat, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.lib.queue import Queue
from hw.memsys.image_layout import COUNT_BITS, WORD_BITS, WORD_BYTES
from hw.memsys.memory_formats import MemoryFormats

__all__ = ["WordWriter"]


class WordWriter(wiring.Component):
    """Writes consecutive words of 64 bits, and no byte beside them. The first one may be any word of a beat.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `MemoryFormats.write_extent`
        Extents.
    i_word : In, stream of ``data``, ``enable``
        The words of each extent in order; a word that is not enabled is skipped, memory keeps the old one.
    o_request : Out, stream of `MemoryFormats.request`
        `MainMemoryPort`'s ``i_write``.
    o_data : Out, stream of `MemoryFormats.write_data`
        Its ``i_write_data``.
    busy : Out(1)
        Requests or words of an extent are still to come.

    Timing
    ------
    Latency: ``1`` cycle from an extent to its first request, ``0`` from the last word of a beat to the beat. One word
    per cycle, without a gap between extents of more than a few words; stalls with ``o_request`` and ``o_data``; two
    extents in flight.
    """

    def __init__(self, *, config: Config):
        self._config, self._formats = config, MemoryFormats(config)
        formats = self._formats
        super().__init__({
            "i": In(stream.Signature(formats.write_extent)),
            "i_word": In(stream.Signature(StructLayout({"data": WORD_BITS, "enable": 1}))),
            "o_request": Out(stream.Signature(formats.request(0))),
            "o_data": Out(stream.Signature(formats.write_data)), "busy": Out(1)})
        self.latency = 1

    def elaborate(self, platform):
        m = Module()
        memory, low = self._config.memory, self._formats.low_bits
        given = self.i.payload
        # The index of a word in its beat; it has no bits where a beat is a word.
        index = given.address[3:low]
        m.submodules.extents = extents = Queue(
            StructLayout({"index": len(index), "length": COUNT_BITS}), depth=2)
        m.d.comb += [extents.i.payload.index.eq(index), extents.i.payload.length.eq(given.length)]

        # Requests of the greatest length, then the rest. ``left``: beats that are still to be requested, less one.
        counted, requests = Signal(), Signal()
        beat, left = Signal(self._formats.beat_bits, reset_less=True), Signal(COUNT_BITS + 1, reset_less=True)
        many = left[memory.length_bits:]
        request = self.o_request
        m.d.comb += [
            self.i.ready.eq(~counted & extents.i.ready), extents.i.valid.eq(self.i.valid & ~counted),
            request.valid.eq(counted), requests.eq(request.valid & request.ready),
            request.payload.address.eq(Cat(Const(0, low), beat)),
            request.payload.length.eq(Mux(many == 0, left[:memory.length_bits], Const(-1, memory.length_bits))),
            self.busy.eq(counted | extents.o.valid)]
        with m.If(self.i.valid & self.i.ready):
            m.d.sync += [counted.eq(1), beat.eq(given.address[low:]), left.eq((given.length + index) >> len(index))]
        with m.If(requests):
            m.d.sync += [beat.eq(beat + (1 << memory.length_bits)), many.eq(many - 1), counted.eq(many != 0)]

        # Words into beats.
        extent, word, begun = extents.o.payload, self.i_word.payload, Signal()
        at, to_come = Signal(len(index)), Signal(COUNT_BITS)
        here, rest = Signal(len(index)), Signal(COUNT_BITS)
        kept, whole = (Signal(self._formats.write_data, name=name) for name in ("kept", "whole"))
        ends, full, takes = Signal(), Signal(), Signal()
        m.d.comb += [
            here.eq(Mux(begun, at, extent.index)), rest.eq(Mux(begun, to_come, extent.length)), ends.eq(rest == 0),
            full.eq(ends | here.all() if len(index) else 1), whole.eq(kept),
            whole.data.word_select(here, WORD_BITS).eq(word.data),
            whole.strobe.word_select(here, WORD_BYTES).eq(word.enable.replicate(WORD_BYTES)),
            self.o_data.payload.eq(whole), self.o_data.valid.eq(self.i_word.valid & extents.o.valid & full),
            self.i_word.ready.eq(extents.o.valid & (self.o_data.ready | ~full)),
            takes.eq(self.i_word.valid & self.i_word.ready), extents.o.ready.eq(takes & ends)]
        with m.If(takes):
            m.d.sync += [begun.eq(~ends), at.eq(here + 1), to_come.eq(rest - 1), kept.eq(whole)]
            with m.If(full):
                m.d.sync += kept.strobe.eq(0)
        return m
