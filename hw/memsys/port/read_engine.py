"""Read engine: several outstanding bursts, replied to in the order of the requests."""

from amaranth.hdl import Cat, Const, Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.lib.checks import count_entries, count_steps
from hw.lib.pipeline import Pipeline
from hw.memsys.port.fault import Fault
from hw.memsys.port.memory_formats import MemoryFormats
from hw.memsys.port.read_buffer import ReadBuffer
from hw.memsys.port.timeout import Timeout

__all__ = ["ReadEngine"]


class ReadEngine(wiring.Component):
    """Reserves a slot of `ReadBuffer` for each burst before it issues the transaction; the slot is the id.

    Beats arrive in any order of ids. The oldest burst leaves when all of it has arrived, then its slot is free. A bad
    burst has a slot too, but no transaction is issued for it.

    When memory is silent for too long the engine *gives up*: all bursts, and those that arrive meanwhile, leave as
    errors at once. It issues transactions again when all outstanding ones have been answered after all: no late beat is
    ever taken for one of another burst.

    Parameters
    ----------
    config
        The configuration.
    tag
        Shape of a sideband value of a request.

    Members
    -------
    i : In, stream of `MemoryFormats.burst`
        Bursts.
    o : Out, stream of `MemoryFormats.reply`
        As many beats as were requested, with ``error`` where there are none.
    o_address : Out, stream of `MemoryFormats.address`
        AXI's AR.
    i_data : In, stream of `MemoryFormats.read_data`
        AXI's R. Always ready.
    o_fault : Out, stream of `MemoryFormats.fault`
        Faults. Always ready.

    Timing
    ------
    Latency: ``4`` cycles from the last beat of the oldest burst at ``i_data`` to its first one at ``o``. One burst per
    cycle is requested, one beat per cycle in and out, without a gap between bursts; stalls with ``o``, with
    ``o_address``, and while ``outstanding`` bursts are in flight.
    """

    def __init__(self, *, config: Config, tag):
        self._config, self._formats, self._tag = config, MemoryFormats(config), tag
        formats = self._formats
        super().__init__({
            "i": In(stream.Signature(formats.burst(tag))), "o": Out(stream.Signature(formats.reply(tag))),
            "o_address": Out(stream.Signature(formats.address)),
            "i_data": In(stream.Signature(formats.read_data, always_ready=True)),
            "o_fault": Out(stream.Signature(formats.fault, always_ready=True))})
        self._leaving = stream.Signature(StructLayout({
            "slot": formats.slot_bits, "beat": formats.burst_bits, "tag": tag, "last": 1, "error": 1})).create()
        self._pipeline = pipeline = Pipeline(self._leaving, self.o)
        beat, self._port = self._leaving.payload, ReadBuffer.port_signature(config).create()
        address = Cat(beat.beat, beat.slot)[:len(self._port.addr)]
        data = pipeline.delay(pipeline.read(self._port, pipeline.input(address)), 1)
        pipeline.output(self.o.payload.data, data)
        for name in "tag", "last", "error":
            pipeline.output(self.o.payload[name], pipeline.input(beat[name]))
        # The register at the buffer, the status bit of the slot, and the buffer.
        self.latency = ReadBuffer.latency + 1 + pipeline.latency

    def elaborate(self, platform):
        m = Module()
        formats, slots = self._formats, self._config.memory.outstanding
        m.submodules.read_buffer = buffer = ReadBuffer(config=self._config)
        m.submodules.timeout = timeout = Timeout(bits=self._config.memory.timeout_bits)
        m.submodules.bursts = bursts = Memory(shape=formats.burst(self._tag), depth=slots, init=[],
                                              attrs={"ram_style": "distributed"})
        wiring.connect(m, wiring.flipped(self.i_data), buffer.i)
        m.d.comb += [buffer.port.addr.eq(self._port.addr), buffer.port.en.eq(self._port.en),
                     self._port.data.eq(buffer.port.data)]
        newest, oldest, level = Signal(formats.slot_bits), Signal(formats.slot_bits), Signal(range(slots + 1))
        gives_up, enters, leaves = Signal(), Signal(), Signal()
        count_entries(level)
        count_steps(m, level, up=enters, down=leaves, most=slots)

        # Requests.
        requests, address, write = ~self.i.payload.bad & ~gives_up, self.o_address, bursts.write_port()
        m.d.comb += [
            self.i.ready.eq((level != slots) & (~address.valid | address.ready | ~requests)),
            enters.eq(self.i.valid & self.i.ready), write.addr.eq(newest), write.data.eq(self.i.payload),
            write.en.eq(enters), write.data.bad.eq(~requests), buffer.start.eq(enters & requests),
            buffer.slot.eq(newest), buffer.length.eq(self.i.payload.length), buffer.offered.eq(address.valid),
            buffer.offered_slot.eq(address.payload.id)]
        with m.If(address.ready):
            m.d.sync += address.valid.eq(0)
        with m.If(enters):
            m.d.sync += newest.eq(newest + 1 if slots > 1 else 0)
        with m.If(enters & requests):
            m.d.sync += [address.valid.eq(1), address.payload.id.eq(newest),
                         address.payload.first.eq(self.i.payload.first),
                         address.payload.length.eq(self.i.payload.length)]

        # Replies.
        read, leaving, beat = bursts.read_port(domain="comb"), self._leaving, Signal(formats.burst_bits)
        burst, ends = read.data, beat == read.data.length
        m.d.comb += [
            read.addr.eq(oldest),
            leaving.valid.eq((level != 0) & (burst.bad | gives_up | ~buffer.outstanding.bit_select(oldest, 1))),
            leaving.payload.slot.eq(oldest), leaving.payload.beat.eq(beat), leaving.payload.tag.eq(burst.tag),
            leaving.payload.last.eq(burst.ends & ends),
            leaving.payload.error.eq(burst.bad | gives_up | buffer.wrong.bit_select(oldest, 1)),
            leaves.eq(leaving.valid & leaving.ready & ends)]
        with m.If(leaving.valid & leaving.ready):
            m.d.sync += beat.eq(beat + 1)
        with m.If(leaves):
            m.d.sync += [beat.eq(0), oldest.eq(oldest + 1 if slots > 1 else 0)]
        self._pipeline.add_to(m)
        self._add_faults(m, buffer=buffer, bursts=bursts, timeout=timeout, gives_up=gives_up, oldest=burst.first)
        return m

    def _add_faults(self, m, *, buffer, bursts, timeout, gives_up, oldest):
        """Faults. A beat that no slot waits for is no answer; a time-out has the address of the oldest burst."""
        read, waits = bursts.read_port(domain="comb"), Signal()
        m.d.sync += waits.eq(buffer.outstanding.any())
        m.d.comb += [read.addr.eq(buffer.beat_slot), timeout.waits.eq(waits & ~gives_up),
                     timeout.moves.eq(buffer.stored)]
        with m.If(timeout.expired):
            m.d.sync += gives_up.eq(1)
        with m.Elif(~buffer.outstanding.any()):
            m.d.sync += gives_up.eq(0)
        code, number = self.o_fault.payload.code, Signal(self._formats.beat_bits, reset_less=True)
        m.d.comb += self.o_fault.payload.address.eq(Cat(Const(0, self._formats.low_bits), number))
        m.d.sync += [self.o_fault.valid.eq(0), number.eq(read.data.first)]
        with m.If(timeout.expired & ~gives_up):
            m.d.sync += [self.o_fault.valid.eq(1), code.eq(Fault.READ_TIMEOUT), number.eq(oldest)]
        with m.Elif(buffer.unexpected):
            m.d.sync += [self.o_fault.valid.eq(1), code.eq(Fault.READ_PROTOCOL)]
        with m.Elif(buffer.failed):
            m.d.sync += [self.o_fault.valid.eq(1), code.eq(Fault.READ_REPLY)]
