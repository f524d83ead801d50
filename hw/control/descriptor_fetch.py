"""Descriptor fetch: the descriptors of a ring in main memory, each with its near cells, word by word."""

from amaranth.hdl import Cat, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from golden.engine.jobs.descriptor import NEAR_ALIGNMENT
from hw.control.job_formats import DESCRIPTOR_WORDS, NEAR_INDEX, WORD_BITS, JobFormats, Kind, elements
from hw.lib.checks import count_steps
from hw.lib.pipeline import Pipeline
from hw.lib.queue import Queue
from hw.memsys.port.memory_formats import MemoryFormats, saturated
from hw.memsys.port.word_reader import WordReader
from hw.registers.engine_registers import RING_BITS

__all__ = ["DescriptorFetch"]

# Descriptors and words of near cells that have been requested and not sent yet, at most; powers of two. Words of near
# cells that are requested at once, at most; extents in flight, at most.
DESCRIPTORS, NEAR_WORDS, CHUNK, EXTENTS = 4, 128, 16, 16
# A descriptor takes a power of two of entries.
SLOT_BITS = (DESCRIPTOR_WORDS - 1).bit_length()


class DescriptorFetch(wiring.Component):
    """Reads descriptor after descriptor, and sends each with its near cells: 24 words, then two cells a word, and
    behind them a listed ray a word.

    ::

        extents of descriptors -+- WordReader - memory - o
        extents of near cells --'       '- address and number of near cells

    The descriptors up to ``doorbell`` are read ahead, and so are their near cells. An extent is requested when the
    memory has free entries for all of it: replies never wait. Near cells are read if the descriptor is one of a
    section, their address is a multiple of 8 and has as many bits as those of memory, and neither they nor the listed
    rays are more than a cluster can store; else there are none. Nothing else is checked.

    After a reset the first descriptor is the one with the number ``taken``.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    ring : In(address_bits)
        Address of the ring, a multiple of 64. Stable while ``taken`` and ``doorbell`` differ, like ``ring_bits``.
    ring_bits : In(RING_BITS)
        It has 2^b entries.
    doorbell, taken : In(32)
        Descriptors ever submitted, and taken, modulo 2^32.
    enable : In(1)
        Nothing is requested while it is 0.
    o : Out, stream of `JobFormats.fetched`
        Words.
    o_request : Out, stream of `MemoryFormats.request`
        `MainMemoryPort`'s ``i_read``.
    i_reply : In, stream of `MemoryFormats.reply`
        Its ``o_read``. Always ready while an extent is in flight.

    Timing
    ------
    Latency: ``3`` cycles from a reply to its first word. One word per cycle; stalls with ``o``. A descriptor is
    requested while fewer than 4 wait to be sent; near cells ahead of descriptors, in extents of at most 16 words.

    Golden counterpart: `golden.engine.jobs.descriptor`.
    """

    latency = 3

    def __init__(self, *, config: Config):
        self._config, formats = config, MemoryFormats(config)
        fetched = JobFormats(config).fetched
        super().__init__({
            "ring": In(config.memory.address_bits), "ring_bits": In(RING_BITS), "doorbell": In(32), "taken": In(32),
            "enable": In(1), "o": Out(stream.Signature(fetched)),
            "o_request": Out(stream.Signature(formats.request(0))), "i_reply": In(stream.Signature(formats.reply(0)))})
        # Of each word its data, and whether it could not be read. Descriptors are in the lower half.
        self._memory = Memory(shape=WORD_BITS + 1, depth=2 * max(DESCRIPTORS << SLOT_BITS, NEAR_WORDS), init=[])
        self._address = range(self._memory.depth)
        self._near_bits = config.ctu.near_cell_bits
        self._near_count = range((1 << self._near_bits) // 2 + config.icu.listed_rays + 1)
        self._steps = stream.Signature(StructLayout({
            "address": self._address, "index": range(NEAR_INDEX + 1), "last": 1})).create()
        step = self._steps.payload
        self._pipeline = pipeline = Pipeline(self._steps, self.o)
        word = pipeline.delay(pipeline.read(self._memory.read_port(), pipeline.input(step.address)), 1)
        pipeline.output(Cat(self.o.payload.data, self.o.payload.error), word)
        for name in "index", "last":
            pipeline.output(self.o.payload[name], pipeline.input(step[name]))

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = self._memory
        m.submodules.reader = reader = WordReader(config=self._config)
        # Extents in flight; near cells to request; by descriptor the words of near cells that follow it.
        m.submodules.extents = extents = Queue(1, depth=EXTENTS)
        m.submodules.near = near = Queue(StructLayout({
            "address": self._config.memory.address_bits, "count": self._near_count}), depth=DESCRIPTORS)
        m.submodules.counts = counts = Queue(self._near_count, depth=DESCRIPTORS)
        self._pipeline.add_to(m)
        wiring.connect(m, reader.o_request, wiring.flipped(self.o_request))
        wiring.connect(m, wiring.flipped(self.i_reply), reader.i_reply)
        sent_word, sent_descriptor = self._add_steps(m, counts)
        self._add_requests(m, reader=reader, extents=extents, near=near, sent_word=sent_word,
                           sent_descriptor=sent_descriptor)
        self._add_words(m, reader=reader, extents=extents, near=near, counts=counts)
        return m

    def _add_requests(self, m, *, reader, extents, near, sent_word, sent_descriptor):
        """Extents of near cells, else of descriptors."""
        begun, number = Signal(), Signal(32)
        held, reserved = Signal(range(DESCRIPTORS + 1)), Signal(range(NEAR_WORDS + 1))
        with m.If(self.enable & ~begun):
            m.d.sync += [begun.eq(1), number.eq(self.taken)]
        extent, is_near = reader.i.payload, Signal()
        done, left, chunk = (Signal(self._near_count, name=name) for name in ("done", "left", "chunk"))
        entry = Signal.like(number)
        m.d.comb += [
            left.eq(near.o.payload["count"] - done), chunk.eq(Mux(left < CHUNK, left, CHUNK)),
            is_near.eq(near.o.valid & (reserved <= NEAR_WORDS - CHUNK)),
            entry.eq(number & ((1 << self.ring_bits) - 1)), extents.i.payload.eq(is_near),
            extent.address.eq(saturated(Mux(is_near, near.o.payload.address + (done << 3),
                                            self.ring + (entry << 7) + (entry << 6)), len(self.ring))),
            extent.length.eq(Mux(is_near, chunk, DESCRIPTOR_WORDS) - 1), extent.narrow.eq(0)]
        requests, may = Signal(), Signal()
        m.d.comb += [
            may.eq(self.enable & begun & (is_near | ((held != DESCRIPTORS) & (number != self.doorbell)))),
            reader.i.valid.eq(may & extents.i.ready), extents.i.valid.eq(may & reader.i.ready),
            requests.eq(reader.i.valid & reader.i.ready),
            near.o.ready.eq(requests & is_near & (left == chunk))]
        with m.If(requests & is_near):
            m.d.sync += done.eq(Mux(left == chunk, 0, done + chunk))
        with m.If(requests & ~is_near):
            m.d.sync += number.eq(number + 1)
        count_steps(m, held, up=requests & ~is_near, down=sent_descriptor, most=DESCRIPTORS)
        count_steps(m, reserved, up=Mux(requests & is_near, chunk, 0), down=sent_word, most=NEAR_WORDS)

    def _add_words(self, m, *, reader, extents, near, counts):
        """Words that arrive, to the memory; what a descriptor's words say of its near cells."""
        word, is_near, write = reader.o, extents.o.payload, self._memory.write_port()
        index, slot = Signal(range(DESCRIPTOR_WORDS)), Signal(range(DESCRIPTORS))
        tail, arrives = Signal(range(NEAR_WORDS)), Signal()
        m.d.comb += [
            word.ready.eq(1), arrives.eq(word.valid), extents.o.ready.eq(arrives & word.payload.last),
            write.en.eq(arrives), write.data.eq(Cat(word.payload.data, word.payload.error)),
            write.addr.eq(Mux(is_near, Cat(tail, Const(1, 1)), Cat(Cat(index, Const(0, SLOT_BITS))[:SLOT_BITS], slot)))]
        with m.If(arrives & is_near):
            m.d.sync += tail.eq(tail + 1)
        with m.If(arrives & ~is_near):
            m.d.sync += index.eq(Mux(word.payload.last, 0, index + 1))
            with m.If(word.payload.last):
                m.d.sync += slot.eq(slot + 1)
        m.d.comb += [self._arrived[0].eq(arrives & ~is_near), self._arrived[1].eq(arrives & is_near)]

        # A word with the number of near cells follows those with the kind and with the address, and one with the number
        # of rays follows it.
        (kind_word, kind_bits), = elements("kind")
        (address_word, address_bits), = elements("near_cells")
        (count_word, count_bits), = elements("near_count")
        last_word = count_word
        is_section, address, error = Signal(), Signal(WORD_BITS), Signal()
        with m.If(arrives & ~is_near):
            m.d.sync += error.eq((error & (index != 0)) | word.payload.error)
            with m.If(index == kind_word):
                m.d.sync += is_section.eq(word.payload.data[kind_bits] == Kind.FRUSTUM)
            with m.If(index == address_word):
                m.d.sync += address.eq(word.payload.data[address_bits])
        count, words, good = word.payload.data[count_bits], Signal(self._near_count), Signal()
        cells, few = (count[:self._near_bits + 1] + 1) >> 1, count <= 1 << self._near_bits
        if self._config.icu.shadow_bits:
            (last_word, bits), = elements("ray_count")
            rays, (near_cells, few_cells) = word.payload.data[bits], (Signal.like(cells), Signal())
            with m.If(arrives & ~is_near & (index == count_word)):
                m.d.sync += [near_cells.eq(cells), few_cells.eq(few)]
            cells = near_cells + rays[:self._config.icu.shadow_bits + 1]
            few = few_cells & (rays <= self._config.icu.listed_rays)
        width = self._config.memory.address_bits
        m.d.comb += [
            good.eq(is_section & ~error & ~word.payload.error & few & (address[:NEAR_ALIGNMENT.bit_length() - 1] == 0)
                    & (address[width:] == 0)),
            words.eq(Mux(good, cells, 0)),
            counts.i.payload.eq(words), counts.i.valid.eq(arrives & ~is_near & (index == last_word)),
            near.i.payload.address.eq(address), near.i.payload["count"].eq(words),
            near.i.valid.eq(counts.i.valid & (words != 0))]

    def _add_steps(self, m, counts):
        """Words that leave. Gives when a word of near cells does, and when the last word of a descriptor and of its
        near cells does.
        """
        self._arrived = [Signal(name=f"arrived_{name}") for name in ("descriptor", "near")]
        levels = [Signal(range(size + 1), name=f"level_{name}") for name, size in (
            ("descriptor", DESCRIPTORS * DESCRIPTOR_WORDS), ("near", NEAR_WORDS))]
        steps, index, slot = self._steps, Signal(range(NEAR_INDEX + 1)), Signal(range(DESCRIPTORS))
        head, done, ends, is_near = Signal(range(NEAR_WORDS)), Signal(self._near_count), Signal(), Signal()
        left = [Signal(name=f"leaves_{name}") for name in ("descriptor", "near")]
        m.d.comb += [
            is_near.eq(index == NEAR_INDEX),
            ends.eq(Mux(is_near, done + 1 == counts.o.payload, (index == NEAR_INDEX - 1) & (counts.o.payload == 0))),
            steps.valid.eq(Mux(is_near, levels[1] != 0, levels[0] != 0)), steps.payload.index.eq(index),
            steps.payload.last.eq(ends),
            steps.payload.address.eq(Mux(is_near, Cat(head, Const(1, 1)), Cat(index[:SLOT_BITS], slot))),
            left[0].eq(steps.valid & steps.ready & ~is_near), left[1].eq(steps.valid & steps.ready & is_near),
            counts.o.ready.eq((left[0] | left[1]) & ends)]
        for level, arrived, leaves in zip(levels, self._arrived, left, strict=True):
            count_steps(m, level, up=arrived, down=leaves, most=(1 << len(level)) - 1)
        with m.If(left[0]):
            m.d.sync += index.eq(index + 1)
            with m.If(index == NEAR_INDEX - 1):
                m.d.sync += slot.eq(slot + 1)
        with m.If(left[1]):
            m.d.sync += [head.eq(head + 1), done.eq(done + 1)]
        with m.If(counts.o.ready):
            m.d.sync += [index.eq(0), done.eq(0)]
        return left[1], counts.o.ready
