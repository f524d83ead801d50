"""Read buffer: beats of outstanding bursts, by slot."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory, ReadPort
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.memsys.port.memory_formats import MemoryFormats

__all__ = ["ReadBuffer"]


class ReadBuffer(wiring.Component):
    """Stores the beats of several bursts, in any order of the bursts, and checks that each has its number of beats.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    start : In(1)
        A burst is requested for a slot, which is free.
    slot : In(slot_bits)
        That slot.
    length : In(burst_bits)
        Length of the burst.
    offered : In(1)
        Memory has not yet accepted the address of the latest burst.
    offered_slot : In(slot_bits)
        The slot of that burst: a beat for it is unexpected.
    i : In, stream of `MemoryFormats.read_data`
        Beats of memory; the id is the slot. Always ready.
    outstanding, wrong : Out(outstanding)
        By slot: beats are missing; one of them was an error, or one too few or too many.
    beat_slot : Out(slot_bits)
        The slot of the beat of the previous cycle.
    stored, unexpected, failed : Out(1)
        That beat is in the buffer; no slot waits for it, or its burst has another length; memory answers with an error.
    port : Out, `ReadPort.Signature`
        Reads the buffer, a beat by its index in the burst and its slot.

    Timing
    ------
    Latency: ``1`` cycle from a beat to the buffer. One beat per cycle; never stalls.
    """

    latency = 1

    def __init__(self, *, config: Config):
        self._config, self._formats = config, MemoryFormats(config)
        formats, slots = self._formats, config.memory.outstanding
        super().__init__({
            "start": In(1), "slot": In(formats.slot_bits), "length": In(formats.burst_bits), "offered": In(1),
            "offered_slot": In(formats.slot_bits),
            "i": In(stream.Signature(formats.read_data, always_ready=True)), "outstanding": Out(slots),
            "wrong": Out(slots), "beat_slot": Out(formats.slot_bits), "stored": Out(1), "unexpected": Out(1),
            "failed": Out(1),
            "port": Out(self.port_signature(config))})
        self._address_bits = len(self.port.addr)

    @staticmethod
    def port_signature(config: Config) -> ReadPort.Signature:
        """The signature of ``port``. The number of one slot alone takes no bits of an address."""
        return ReadPort.Signature(
            addr_width=config.memory.outstanding.bit_length() - 1 + MemoryFormats(config).burst_bits,
            shape=config.memory.data_bits)

    def elaborate(self, platform):
        m = Module()
        formats, slots = self._formats, self._config.memory.outstanding
        m.submodules.buffer = buffer = Memory(shape=self._config.memory.data_bits, depth=1 << self._address_bits,
                                              init=[], attrs={"no_rw_check": 1})
        m.submodules.lengths = lengths = Memory(shape=formats.burst_bits, depth=slots, init=[],
                                                attrs={"ram_style": "distributed"})
        # Beats that have been stored, and whether they are all.
        stored = StructLayout({"beats": formats.burst_bits, "full": 1})
        m.submodules.counts = counts = Memory(shape=stored, depth=slots, init=[], attrs={"ram_style": "distributed"})
        read, write = buffer.read_port(), buffer.write_port()
        m.d.comb += [read.addr.eq(self.port.addr), read.en.eq(self.port.en), self.port.data.eq(read.data)]
        comes, early, beat = Signal(), Signal(), Signal.like(self.i.payload, reset_less=True)
        m.d.sync += [comes.eq(self.i.valid), beat.eq(self.i.payload),
                     early.eq((self.start & (self.slot == self.i.payload.id))
                              | (self.offered & (self.offered_slot == self.i.payload.id)))]
        length_read, length_write = lengths.read_port(domain="comb"), lengths.write_port()
        count_read, count_write = counts.read_port(domain="comb"), counts.write_port()
        # By slot: no beat has been stored.
        fresh, count, known = Signal(slots), Signal(stored), Signal()
        at_end = count.beats == length_read.data
        miscounted = (beat.last != at_end) | count.full
        m.d.comb += [
            length_write.addr.eq(self.slot), length_write.data.eq(self.length), length_write.en.eq(self.start),
            *(port.addr.eq(beat.id) for port in (count_read, length_read, count_write)), self.beat_slot.eq(beat.id),
            count.eq(Mux(fresh.bit_select(beat.id, 1), 0, count_read.data)),
            known.eq(self.outstanding.bit_select(beat.id, 1) & ~early),
            count_write.data.beats.eq(count.beats + 1), count_write.data.full.eq(count.full | at_end),
            count_write.en.eq(comes & known), write.addr.eq(Cat(count.beats, beat.id)[:len(write.addr)]),
            write.data.eq(beat.data), write.en.eq(self.stored), self.stored.eq(comes & known & ~count.full),
            self.unexpected.eq(comes & (~known | miscounted)), self.failed.eq(comes & beat.response[1])]
        with m.If(comes & known):
            m.d.sync += fresh.bit_select(beat.id, 1).eq(0)
            with m.If(beat.last):
                m.d.sync += self.outstanding.bit_select(beat.id, 1).eq(0)
            with m.If(beat.response[1] | miscounted):
                m.d.sync += self.wrong.bit_select(beat.id, 1).eq(1)
        with m.If(self.start):
            m.d.sync += [self.outstanding.bit_select(self.slot, 1).eq(1), fresh.bit_select(self.slot, 1).eq(1),
                         self.wrong.bit_select(self.slot, 1).eq(0)]
        return m
