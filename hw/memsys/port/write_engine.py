"""Write engine: several outstanding bursts of writes."""

from amaranth.hdl import Cat, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.lib.checks import count_steps
from hw.lib.queue import Queue
from hw.memsys.port.fault import Fault
from hw.memsys.port.memory_formats import MemoryFormats
from hw.memsys.port.timeout import Timeout

__all__ = ["WriteEngine"]


class WriteEngine(wiring.Component):
    """Sends the data of bursts, and answers each request once, when all of it has been written or cannot be.

    All bursts have id 0, so memory answers them in order. An answer is expected once memory has accepted address and
    data of a burst. The data of a bad burst are accepted and discarded.

    When memory is silent for too long the engine *gives up*: all bursts, and those that arrive meanwhile, are errors at
    once, and their data are discarded; the rest of a burst whose transaction has been issued is sent without any byte
    enabled. It issues transactions again when all outstanding ones have been answered after all.

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
    i_data : In, stream of `MemoryFormats.write_data`
        Their beats.
    o : Out, stream of `MemoryFormats.written`
        One for each request.
    o_address : Out, stream of `MemoryFormats.address`
        AXI's AW.
    o_data : Out, stream of `MemoryFormats.wire_data`
        AXI's W.
    i_response : In, stream of `MemoryFormats.response`
        AXI's B.
    o_fault : Out, stream of `MemoryFormats.fault`
        Faults. Always ready.
    incomplete : Out(1)
        Beats of a burst that has been accepted have not come; an error may have been answered before.

    Timing
    ------
    Latency: ``1`` cycle from ``i_data`` to ``o_data``, and from ``i_response`` to ``o``. One beat per cycle, without a
    gap between bursts; stalls with ``i_data``, ``o_address``, ``o_data`` and ``o``, and while ``outstanding`` bursts
    are in flight.
    """

    def __init__(self, *, config: Config, tag):
        self._config, self._formats, self._tag = config, MemoryFormats(config), tag
        formats = self._formats
        super().__init__({
            "i": In(stream.Signature(formats.burst(tag))), "i_data": In(stream.Signature(formats.write_data)),
            "o": Out(stream.Signature(formats.written(tag))),
            "o_address": Out(stream.Signature(formats.address)), "o_data": Out(stream.Signature(formats.wire_data)),
            "i_response": In(stream.Signature(formats.response)),
            "o_fault": Out(stream.Signature(formats.fault, always_ready=True)), "incomplete": Out(1)})
        self.latency = 1

    def elaborate(self, platform):
        m = Module()
        formats, slots = self._formats, self._config.memory.outstanding
        m.submodules.timeout = timeout = Timeout(bits=self._config.memory.timeout_bits)
        m.submodules.order = order = Queue(StructLayout({
            "tag": self._tag, "first": formats.beat_bits, "ends": 1, "issued": 1}), depth=slots)
        gives_up = Signal()
        # Outstanding transactions; those of them whose burst is still in the queue, and those whose data memory has
        # accepted.
        outstanding, queued, accepted = (Signal(range(slots + 1), name=name) for name in (
            "outstanding", "queued", "accepted"))

        # Beats of the present burst that the client has still to send, and those that memory has still to receive: the
        # same beats while they are joint.
        taken_left, sent_left = (Signal(range(self._config.memory.burst_beats + 1)) for _ in range(2))
        joint = Signal()
        takes, sends, enters, issues = (Signal(name=name) for name in ("takes", "sends", "enters", "issues"))
        address_free = ~self.o_address.valid | self.o_address.ready
        data_free = ~self.o_data.valid | self.o_data.ready
        taken = (taken_left == 0) | ((taken_left == 1) & takes)
        sent = (sent_left == 0) | ((sent_left == 1) & sends)
        beats = self.i.payload.length + 1
        m.d.comb += [
            issues.eq(~self.i.payload.bad & ~gives_up),
            self.i_data.ready.eq((taken_left != 0) & (data_free | ~joint)),
            takes.eq(self.i_data.valid & self.i_data.ready),
            sends.eq((sent_left != 0) & data_free & (takes | ~joint)),
            self.i.ready.eq(taken & order.i.ready & (~issues | (sent & address_free & (outstanding != slots)))),
            enters.eq(self.i.valid & self.i.ready), order.i.valid.eq(enters),
            order.i.payload.tag.eq(self.i.payload.tag), order.i.payload.first.eq(self.i.payload.first),
            order.i.payload.ends.eq(self.i.payload.ends), order.i.payload.issued.eq(issues)]
        m.d.comb += self.incomplete.eq(taken_left != 0)
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
            m.d.sync += [taken_left.eq(beats), joint.eq(issues)]
            with m.If(issues):
                m.d.sync += [sent_left.eq(beats), self.o_address.valid.eq(1),
                             self.o_address.payload.first.eq(self.i.payload.first),
                             self.o_address.payload.length.eq(self.i.payload.length)]

        # Answers, in order. An error of any burst is one of its request.
        wrong, leaves = Signal(), Signal()
        head, response = order.o.payload, self.i_response
        free = ~head.ends | ~self.o.valid | self.o.ready
        # Memory may accept the address of the newest burst after its data.
        unaddressed = self.o_address.valid & (sent_left == 0) & ~self.o_data.valid
        expected = (accepted > unaddressed) & (response.payload.id == 0)
        answers = Signal()
        error = wrong | ~head.issued | gives_up | response.payload.response[1]
        m.d.comb += [
            leaves.eq(order.o.valid & free & (~head.issued | gives_up | (response.valid & expected))),
            order.o.ready.eq(leaves), response.ready.eq(gives_up | ~expected | (order.o.valid & head.issued & free)),
            answers.eq(response.valid & response.ready & expected)]
        ends = self.o_data.valid & self.o_data.ready & self.o_data.payload.last
        for count, up, down in ((outstanding, enters & issues, answers), (accepted, ends, answers),
                                (queued, enters & issues, leaves & head.issued)):
            count_steps(m, count, up=up, down=down, most=slots)
        with m.If(self.o.ready):
            m.d.sync += self.o.valid.eq(0)
        with m.If(leaves):
            m.d.sync += wrong.eq(error & ~head.ends)
            with m.If(head.ends):
                m.d.sync += [self.o.valid.eq(1), self.o.payload.tag.eq(head.tag), self.o.payload.error.eq(error)]

        # Faults. A stall of the client is no time-out.
        sent_all = self.o_address.valid | self.o_data.valid | ~(joint & (taken_left != 0))
        m.d.comb += [
            timeout.waits.eq((outstanding != 0) & sent_all & ~gives_up),
            timeout.moves.eq((self.o_address.valid & self.o_address.ready) | (self.o_data.valid & self.o_data.ready)
                             | (response.valid & expected))]
        with m.If(timeout.expired):
            m.d.sync += gives_up.eq(1)
        with m.Elif((outstanding == 0) & (queued == 0) & (sent_left == 0) & ~self.o_data.valid & ~self.o_address.valid):
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
