"""Write engine: bursts of data, several of them under way."""

from amaranth.hdl import Cat, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.lib.queue import Queue
from hw.memsys.fault import Fault
from hw.memsys.memory_formats import MemoryFormats
from hw.memsys.timeout import Timeout

__all__ = ["WriteEngine"]


class WriteEngine(wiring.Component):
    """Puts data behind bursts and answers each request once, when all of it has been written or cannot be.

    All bursts have id 0, so memory answers them in order. Data of a bad burst are taken and dropped.

    When memory is silent for too long the engine *gives up*: all bursts, and those that come meanwhile, are errors at
    once, and their data are dropped; what is left of a burst that memory has been told of goes out without any byte
    enabled. It writes again when every burst has been answered after all.

    Parameters
    ----------
    config
        The configuration.
    tag
        Shape of what goes along with a request.

    Members
    -------
    i, i_data
        `MemoryFormats.burst` and `MemoryFormats.write_data`, as many as the bursts have beats.
    o
        `MemoryFormats.written`, one for each request.
    o_address, o_data, i_response
        AXI.
    o_fault
        What went wrong. Always ready.

    Timing
    ------
    Latency: ``1`` cycle from ``i_data`` to ``o_data``, and from ``i_response`` to ``o``. One beat per cycle, without a
    gap between bursts; stalls with ``i_data``, ``o_address``, ``o_data`` and ``o``, and while ``outstanding`` bursts
    are under way.
    """

    def __init__(self, *, config: Config, tag):
        self._config, self._formats, self._tag = config, MemoryFormats(config), tag
        formats = self._formats
        super().__init__({
            "i": In(stream.Signature(formats.burst(tag))), "i_data": In(stream.Signature(formats.write_data)),
            "o": Out(stream.Signature(formats.written(tag))),
            "o_address": Out(stream.Signature(formats.address)), "o_data": Out(stream.Signature(formats.wire_data)),
            "i_response": In(stream.Signature(formats.response)),
            "o_fault": Out(stream.Signature(formats.fault, always_ready=True))})
        self.latency = 1

    def elaborate(self, platform):
        m = Module()
        formats, slots = self._formats, self._config.memory.outstanding
        m.submodules.timeout = timeout = Timeout(bits=self._config.memory.timeout_bits)
        m.submodules.order = order = Queue(StructLayout({
            "tag": self._tag, "first": formats.beat_bits, "ends": 1, "asked": 1}), depth=slots)
        gives_up = Signal()
        # Bursts that memory owes an answer; those of them that have not been answered in the queue.
        owed, asked = Signal(range(slots + 1)), Signal(range(slots + 1))

        # Beats that the client owes the present burst, and beats that the burst owes memory: the same beats while they
        # are joint.
        taken_left, sent_left = (Signal(range(self._config.memory.burst_beats + 1)) for _ in range(2))
        joint = Signal()
        takes, sends, enters, asks = (Signal(name=name) for name in ("takes", "sends", "enters", "asks"))
        address_free = ~self.o_address.valid | self.o_address.ready
        data_free = ~self.o_data.valid | self.o_data.ready
        taken = (taken_left == 0) | ((taken_left == 1) & takes)
        sent = (sent_left == 0) | ((sent_left == 1) & sends)
        beats = self.i.payload.length + 1
        m.d.comb += [
            asks.eq(~self.i.payload.bad & ~gives_up),
            self.i_data.ready.eq((taken_left != 0) & (data_free | ~joint)),
            takes.eq(self.i_data.valid & self.i_data.ready),
            sends.eq((sent_left != 0) & data_free & (takes | ~joint)),
            self.i.ready.eq(taken & order.i.ready & (~asks | (sent & address_free & (owed != slots)))),
            enters.eq(self.i.valid & self.i.ready), order.i.valid.eq(enters),
            order.i.payload.tag.eq(self.i.payload.tag), order.i.payload.first.eq(self.i.payload.first),
            order.i.payload.ends.eq(self.i.payload.ends), order.i.payload.asked.eq(asks)]
        with m.If(takes):
            m.d.sync += taken_left.eq(taken_left - 1)
        with m.If(sends):
            m.d.sync += [sent_left.eq(sent_left - 1), self.o_data.payload.data.eq(self.i_data.payload.data),
                         self.o_data.payload.strobe.eq(Mux(joint, self.i_data.payload.strobe, 0)),
                         self.o_data.payload.last.eq(sent_left == 1)]
        with m.If(data_free):
            m.d.sync += self.o_data.valid.eq(sends)
        with m.If(gives_up):
            m.d.sync += joint.eq(0)
        with m.If(self.o_address.ready):
            m.d.sync += self.o_address.valid.eq(0)
        with m.If(enters):
            m.d.sync += [taken_left.eq(beats), joint.eq(asks)]
            with m.If(asks):
                m.d.sync += [sent_left.eq(beats), self.o_address.valid.eq(1),
                             self.o_address.payload.first.eq(self.i.payload.first),
                             self.o_address.payload.length.eq(self.i.payload.length)]

        # Answers, in order. Of a request that takes several bursts the errors add up.
        wrong, leaves = Signal(), Signal()
        head, response = order.o.payload, self.i_response
        room = ~head.ends | ~self.o.valid | self.o.ready
        expected = (owed != 0) & (response.payload.id == 0)
        answers = Signal()
        error = wrong | ~head.asked | gives_up | response.payload.response[1]
        m.d.comb += [
            leaves.eq(order.o.valid & room & (~head.asked | gives_up | (response.valid & expected))),
            order.o.ready.eq(leaves), response.ready.eq(gives_up | ~expected | (order.o.valid & head.asked & room)),
            answers.eq(response.valid & response.ready & expected)]
        m.d.sync += [owed.eq(owed + (enters & asks) - answers),
                     asked.eq(asked + (enters & asks) - (leaves & head.asked))]
        with m.If(self.o.ready):
            m.d.sync += self.o.valid.eq(0)
        with m.If(leaves):
            m.d.sync += wrong.eq(error & ~head.ends)
            with m.If(head.ends):
                m.d.sync += [self.o.valid.eq(1), self.o.payload.tag.eq(head.tag), self.o.payload.error.eq(error)]

        # What goes wrong. Waiting for the client does not count.
        told = self.o_address.valid | self.o_data.valid | ~(joint & (taken_left != 0))
        m.d.comb += [
            timeout.waits.eq((owed != 0) & told & ~gives_up),
            timeout.moves.eq((self.o_address.valid & self.o_address.ready) | (self.o_data.valid & self.o_data.ready)
                             | (response.valid & expected))]
        with m.If(timeout.expired):
            m.d.sync += gives_up.eq(1)
        with m.Elif((owed == 0) & (asked == 0) & (sent_left == 0) & ~self.o_data.valid & ~self.o_address.valid):
            m.d.sync += gives_up.eq(0)
        code, number = self.o_fault.payload.code, Signal(formats.beat_bits, reset_less=True)
        m.d.comb += self.o_fault.payload.address.eq(Cat(Const(0, formats.low_bits), number))
        m.d.sync += [self.o_fault.valid.eq(0), number.eq(head.first)]
        with m.If(timeout.expired & ~gives_up):
            m.d.sync += [self.o_fault.valid.eq(1), code.eq(Fault.WRITE_TIMEOUT)]
        with m.Elif(response.valid & response.ready & ~expected):
            m.d.sync += [self.o_fault.valid.eq(1), code.eq(Fault.WRITE_PROTOCOL)]
        with m.Elif(answers & response.payload.response[1] & ~gives_up):
            m.d.sync += [self.o_fault.valid.eq(1), code.eq(Fault.WRITE_REPLY)]
        return m
