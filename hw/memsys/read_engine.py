"""Read engine: several bursts under way, their beats in the order in which they were asked for."""

from amaranth.hdl import Cat, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory, ReadPort
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.lib.pipeline import Pipeline
from hw.memsys.fault import Fault
from hw.memsys.memory_formats import MemoryFormats
from hw.memsys.timeout import Timeout

__all__ = ["ReadEngine"]


class ReadEngine(wiring.Component):
    """Every burst has a slot, with room for the longest one, before memory is asked; the slot's number is its id.

    Beats come in any order of ids. The oldest burst goes out when all of it is there; then its slot is free again.
    A bad burst has a slot too, but memory is not asked for it.

    When memory is silent for too long the engine *gives up*: all bursts, and those that come meanwhile, go out as
    errors at once. It asks again when every burst that it had asked for has been answered after all: no late beat
    is ever taken for one of another burst.

    Parameters
    ----------
    config
        The configuration.
    tag
        Shape of what goes along with a request.

    Members
    -------
    i
        `MemoryFormats.burst`.
    o
        `MemoryFormats.reply`: as many beats as were asked for, with ``error`` where there are none.
    o_address, i_data
        AXI; ``i_data`` is always ready.
    o_fault
        What went wrong. Always ready.

    Timing
    ------
    Latency: ``4`` cycles from the last beat of the oldest burst at ``i_data`` to its first one at ``o``. One burst per
    cycle is asked for, one beat per cycle comes and goes, without a gap between bursts; stalls with ``o``, with
    ``o_address``, and while ``outstanding`` bursts are under way.
    """

    def __init__(self, *, config: Config, tag):
        self._config, self._formats = config, MemoryFormats(config)
        formats, self._tag = self._formats, tag
        super().__init__({
            "i": In(stream.Signature(formats.burst(tag))), "o": Out(stream.Signature(formats.reply(tag))),
            "o_address": Out(stream.Signature(formats.address)),
            "i_data": In(stream.Signature(formats.read_data, always_ready=True)),
            "o_fault": Out(stream.Signature(formats.fault, always_ready=True))})
        self._outgoing = stream.Signature(StructLayout({
            "slot": formats.slot_bits, "beat": formats.burst_bits, "tag": tag, "last": 1, "error": 1})).create()
        self._pipeline = pipeline = Pipeline(self._outgoing, self.o)
        left = self._outgoing.payload
        # With one slot only there is no number of it in an address.
        place = Cat(left.beat, left.slot)[:config.memory.outstanding.bit_length() - 1 + formats.burst_bits]
        self._port = ReadPort.Signature(addr_width=len(place), shape=config.memory.data_bits).create()
        data = pipeline.delay(pipeline.read(self._port, pipeline.input(place)), 1)
        pipeline.output(self.o.payload.data, data)
        for name in "tag", "last", "error":
            pipeline.output(self.o.payload[name], pipeline.input(left[name]))
        # The register of what memory gives, the slot's bit, and the way through the buffer.
        self.latency = 2 + pipeline.latency

    def elaborate(self, platform):
        m = Module()
        formats, slots = self._formats, self._config.memory.outstanding
        m.submodules.buffer = buffer = Memory(shape=self._config.memory.data_bits, depth=slots << formats.burst_bits,
                                              init=[], attrs={"no_rw_check": 1})
        read = buffer.read_port()
        m.d.comb += [read.addr.eq(self._port.addr), read.en.eq(self._port.en), self._port.data.eq(read.data)]
        m.submodules.timeout = timeout = Timeout(bits=self._config.memory.timeout_bits)
        m.submodules.bursts = bursts = Memory(shape=formats.burst(self._tag), depth=slots, init=[],
                                              attrs={"ram_style": "distributed"})
        m.submodules.lengths = lengths = Memory(shape=formats.burst_bits, depth=slots, init=[],
                                                attrs={"ram_style": "distributed"})
        # By slot: memory owes beats; none of them has come; something was wrong with them.
        owed, fresh, wrong = Signal(slots), Signal(slots), Signal(slots)
        newest, oldest, level = Signal(formats.slot_bits), Signal(formats.slot_bits), Signal(range(slots + 1))
        gives_up = Signal()

        def bit(bits, slot):
            return bits.bit_select(slot, 1)

        # A slot for a burst.
        asks = ~self.i.payload.bad & ~gives_up
        address_free = ~self.o_address.valid | self.o_address.ready
        enters, leaves = Signal(), Signal()
        burst_write, length_write = bursts.write_port(), lengths.write_port()
        m.d.comb += [
            self.i.ready.eq((level != slots) & (address_free | ~asks)), enters.eq(self.i.valid & self.i.ready),
            burst_write.addr.eq(newest), burst_write.data.eq(self.i.payload), burst_write.en.eq(enters),
            burst_write.data.bad.eq(~asks), length_write.addr.eq(newest),
            length_write.data.eq(self.i.payload.length), length_write.en.eq(enters)]
        m.d.sync += level.eq(level + enters - leaves)
        with m.If(self.o_address.ready):
            m.d.sync += self.o_address.valid.eq(0)
        with m.If(enters):
            m.d.sync += newest.eq(newest + 1 if slots > 1 else 0)
        with m.If(enters & asks):
            m.d.sync += [self.o_address.valid.eq(1), self.o_address.payload.id.eq(newest),
                         self.o_address.payload.first.eq(self.i.payload.first),
                         self.o_address.payload.length.eq(self.i.payload.length)]

        # Beats into the buffer.
        came, beat = Signal(), Signal.like(self.i_data.payload, reset_less=True)
        m.d.sync += [came.eq(self.i_data.valid), beat.eq(self.i_data.payload)]
        # By slot: beats that have come, and whether those were as many as there must be already.
        so_far = StructLayout({"beats": formats.burst_bits, "full": 1})
        m.submodules.counts = counts = Memory(shape=so_far, depth=slots, init=[], attrs={"ram_style": "distributed"})
        count_read, count_write = counts.read_port(domain="comb"), counts.write_port()
        length_read, about_read = lengths.read_port(domain="comb"), bursts.read_port(domain="comb")
        count, known = Signal(so_far), Signal()
        at_end = count.beats == length_read.data
        amiss = (beat.last != at_end) | count.full
        write = buffer.write_port()
        m.d.comb += [
            *(port.addr.eq(beat.id) for port in (count_read, length_read, about_read, count_write)),
            count.eq(Mux(bit(fresh, beat.id), 0, count_read.data)), known.eq(bit(owed, beat.id)),
            count_write.data.beats.eq(count.beats + 1), count_write.data.full.eq(count.full | at_end),
            count_write.en.eq(came & known), write.addr.eq(Cat(count.beats, beat.id)[:len(write.addr)]),
            write.data.eq(beat.data), write.en.eq(came & known & ~count.full)]
        with m.If(came & known):
            m.d.sync += bit(fresh, beat.id).eq(0)
            with m.If(beat.last):
                m.d.sync += bit(owed, beat.id).eq(0)
            with m.If(beat.response[1] | amiss):
                m.d.sync += bit(wrong, beat.id).eq(1)
        with m.If(enters & asks):
            m.d.sync += [bit(owed, newest).eq(1), bit(fresh, newest).eq(1), bit(wrong, newest).eq(0)]

        # Bursts out of it.
        first_read = bursts.read_port(domain="comb")
        going, outgoing, at = first_read.data, self._outgoing, Signal(formats.burst_bits)
        ends = at == going.length
        m.d.comb += [
            first_read.addr.eq(oldest), outgoing.valid.eq((level != 0) & (going.bad | gives_up | ~bit(owed, oldest))),
            outgoing.payload.slot.eq(oldest), outgoing.payload.beat.eq(at), outgoing.payload.tag.eq(going.tag),
            outgoing.payload.last.eq(going.ends & ends),
            outgoing.payload.error.eq(going.bad | gives_up | bit(wrong, oldest)),
            leaves.eq(outgoing.valid & outgoing.ready & ends)]
        with m.If(outgoing.valid & outgoing.ready):
            m.d.sync += at.eq(at + 1)
        with m.If(leaves):
            m.d.sync += [at.eq(0), oldest.eq(oldest + 1 if slots > 1 else 0)]

        # What goes wrong. Beats that nobody waits for do not count as an answer. A time-out is told with the address of
        # the oldest burst.
        waits = Signal()
        m.d.sync += waits.eq(owed.any())
        m.d.comb += [timeout.waits.eq(waits & ~gives_up), timeout.moves.eq(came & known & ~count.full)]
        with m.If(timeout.expired):
            m.d.sync += gives_up.eq(1)
        with m.Elif(~owed.any()):
            m.d.sync += gives_up.eq(0)
        code, number = self.o_fault.payload.code, Signal(formats.beat_bits, reset_less=True)
        m.d.comb += self.o_fault.payload.address.eq(Cat(Const(0, formats.low_bits), number))
        m.d.sync += [self.o_fault.valid.eq(0), number.eq(about_read.data.first)]
        with m.If(timeout.expired & ~gives_up):
            m.d.sync += [self.o_fault.valid.eq(1), code.eq(Fault.READ_TIMEOUT), number.eq(going.first)]
        with m.Elif(came & (~known | amiss)):
            m.d.sync += [self.o_fault.valid.eq(1), code.eq(Fault.READ_PROTOCOL)]
        with m.Elif(came & beat.response[1]):
            m.d.sync += [self.o_fault.valid.eq(1), code.eq(Fault.READ_REPLY)]
        self._pipeline.add_to(m)
        return m
