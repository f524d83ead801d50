"""List read-out: which rays of a shadow frustum's list are blocked, in the order of the list."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import LIST_WORD_BITS, IcuFormats
from hw.icu.ray_memory import BANKS
from hw.lib.pipeline import Pipeline
from hw.lib.queue import Queue

__all__ = ["ListReadOut"]


class ListReadOut(wiring.Component):
    """Stores where the rays of a list are in the ray memory, and reads one after the other from there.

    There is a list for each bank of the ray memory. A listed ray that is none of the section's is not blocked.

    Parameters
    ----------
    config
        The configuration, with ``icu.shadow_bits``.

    Members
    -------
    i_ray : In, stream of ``bank``, ``ray``, ``is_ray``, ``last``, always ready
        The rays of a list, in its order; the one behind the last one is the first of another list. Not of the bank that
        is being read out.
    i : In, stream of ``bank``
        The bank to read, whose list has come. Accepted when the last word of the list before has left.
    o_read : Out, stream of ``bank``, ``ray``
        To `RayMemory.i_read`.
    i_hit : In, stream of `IcuFormats.hit`
        The replies, in order.
    o : Out, stream of ``index``, ``word``, ``last``
        A bit for each ray, 64 to a word from its lowest bit on: it is blocked. Those behind the last ray are 0.
    busy : Out(1)
        A read-out is in progress.
    bank : Out(1)
        The bank that it reads.

    Timing
    ------
    Latency: ``3`` cycles from ``i`` to the first read, 1 from the last hit of a word to the word. One ray per cycle;
    stalls with ``o``.

    Golden counterpart: `golden.engine.jobs.result_formats.pack_bits`.
    """

    def __init__(self, *, config: Config):
        formats, bits = IcuFormats(config), config.icu.shadow_bits
        self._bits = bits
        place = {"ray": formats.ray, "is_ray": 1}
        super().__init__({
            "i_ray": In(stream.Signature(StructLayout({"bank": 1, **place, "last": 1}), always_ready=True)),
            "i": In(stream.Signature(StructLayout({"bank": 1}))),
            "o_read": Out(stream.Signature(StructLayout({"bank": 1, "ray": formats.ray}))),
            "i_hit": In(stream.Signature(formats.hit)),
            "o": Out(stream.Signature(StructLayout({"index": formats.index, "word": LIST_WORD_BITS, "last": 1}))),
            "busy": Out(1), "bank": Out(1)})
        self._memory = Memory(shape=StructLayout(place), depth=BANKS << bits, init=[], attrs={"no_rw_check": 1})
        self._steps = stream.Signature(StructLayout({"address": bits + 1, "last": 1})).create()
        self._places = stream.Signature(StructLayout({**place, "last": 1})).create()
        self._pipeline = pipeline = Pipeline(self._steps, self._places)
        step, out = self._steps.payload, self._places.payload
        found = pipeline.delay(pipeline.read(self._memory.read_port(), pipeline.input(step.address)), 1)
        for name in place:
            pipeline.output(out[name], pipeline.combine(lambda found, name=name: found[name], found))
        pipeline.output(out.last, pipeline.input(step.last))
        self.latency = 1 + pipeline.latency

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = self._memory
        self._pipeline.add_to(m)
        ends = self._add_list(m)
        # Whether the outstanding reads are of rays of the section.
        m.submodules.outstanding = outstanding = Queue(StructLayout({"is_ray": 1, "last": 1}), depth=16)
        steps, places, reads, index = self._steps, self._places, Signal(), Signal(self._bits)
        m.d.comb += [
            self.i.ready.eq(~self.busy), steps.valid.eq(reads), steps.payload.address.eq(Cat(index, self.bank)),
            steps.payload.last.eq(index == Mux(self.bank, ends[1], ends[0])),
            self.o_read.valid.eq(places.valid & outstanding.i.ready), self.o_read.payload.bank.eq(self.bank),
            self.o_read.payload.ray.eq(places.payload.ray), outstanding.i.valid.eq(places.valid & self.o_read.ready),
            places.ready.eq(self.o_read.ready & outstanding.i.ready),
            *(outstanding.i.payload[name].eq(places.payload[name]) for name in ("is_ray", "last"))]
        with m.If(steps.valid & steps.ready):
            m.d.sync += [index.eq(index + 1), reads.eq(~steps.payload.last)]
        with m.If(self.i.valid & self.i.ready):
            m.d.sync += [self.bank.eq(self.i.payload.bank), self.busy.eq(1), reads.eq(1), index.eq(0)]
        self._add_words(m, outstanding)
        with m.If(self.o.valid & self.o.ready & self.o.payload.last):
            m.d.sync += self.busy.eq(0)
        return m

    def _add_list(self, m):
        """The places of the rays; the last address of each bank's list."""
        write, given, address = self._memory.write_port(), self.i_ray.payload, Signal(self._bits)
        ends = [Signal(self._bits, name=f"end_{bank}") for bank in range(BANKS)]
        m.d.comb += [write.addr.eq(Cat(address, given.bank)), write.en.eq(self.i_ray.valid),
                     *(write.data[name].eq(given[name]) for name in ("ray", "is_ray"))]
        with m.If(self.i_ray.valid):
            m.d.sync += address.eq(Mux(given.last, 0, address + 1))
            for bank, end in enumerate(ends):
                with m.If(given.bank == bank):
                    m.d.sync += end.eq(address)
        return ends

    def _add_words(self, m, outstanding):
        """The word that is being filled, and offered when it is full."""
        word, number, one = self.o.payload, Signal(range(LIST_WORD_BITS)), outstanding.o.payload
        free, takes = Signal(), Signal()
        m.d.comb += [
            free.eq(~self.o.valid | self.o.ready), takes.eq(self.i_hit.valid & outstanding.o.valid & free),
            self.i_hit.ready.eq(outstanding.o.valid & free), outstanding.o.ready.eq(self.i_hit.valid & free)]
        # Of a blocked ray all bits of the inverse distance are set.
        is_blocked = self.i_hit.payload.inverse[-1] & one.is_ray
        with m.If(self.o.ready):
            m.d.sync += self.o.valid.eq(0)
        with m.If(self.o.valid & self.o.ready):
            m.d.sync += word.index.eq(Mux(word.last, 0, word.index + 1))
        with m.If(takes):
            m.d.sync += [
                word.word.eq(Mux(number == 0, 0, word.word) | (is_blocked << number)), word.last.eq(one.last),
                number.eq(Mux(one.last, 0, number + 1)), self.o.valid.eq(one.last | number.all())]
