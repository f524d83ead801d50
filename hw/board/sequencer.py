"""Sequencer: a host that executes a program."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.board.frame import CHECK, CHECK_BYTES, HEADER_BYTES, LENGTH_BITS
from hw.board.program import Operation, Program
from hw.memsys.port.memory_formats import MemoryFormats
from hw.registers.axi_lite_signature import AxiLiteSignature
from hw.registers.engine_registers import ADDRESS_BITS, ENGINE_REGISTERS, register
from hw.registers.register import WORD_BYTES, addresses

__all__ = ["Sequencer"]

BUSY = register("status").pack(busy=1)
HALTED = register("status").pack(halted=1)
FAILED = register("status").pack(failed=1)
# The acknowledgement of an interrupt.
ACKNOWLEDGE = register("interrupt").pack(enable=1, pending=1)
INTERRUPT = addresses(ENGINE_REGISTERS)["interrupt"]
UNPRIVILEGED = 0b010


class Sequencer(wiring.Component):
    """Executes a `Program`: accesses to registers and to main memory, and a stream of bytes.

    A register access that is answered with an error, or reads another value than expected, continues with the program's
    part for errors; in that part it is ignored.

    Parameters
    ----------
    config
        The configuration.
    program
        The program.

    Members
    -------
    host : Out, `AxiLiteSignature`
        The registers.
    o_peek : Out, stream of the number of a beat
        Reads of main memory.
    i_peek : In, stream of a beat
        The beat.
    o : Out, stream of bytes
        Frames (`hw.board.frame`).
    irq : In(1)
        The machine's.
    again : In(1)
        Restart the program after its end.
    restarts : Out(1)
        The program restarts in the next cycle; the machine is to be reset.
    busy : Out(1)
        The program runs.
    failed : Out(1)
        It runs its part for errors, or has ended there.

    Timing
    ------
    Three cycles for a step, and the access it waits for; one access at a time. A WAIT stalls until ``irq``, bytes
    with ``o``.
    """

    def __init__(self, *, config: Config, program: Program):
        self._config, self._program, self._formats = config, program, MemoryFormats(config)
        super().__init__({
            "host": Out(AxiLiteSignature(address_bits=ADDRESS_BITS)),
            "o_peek": Out(stream.Signature(self._formats.beat_bits)),
            "i_peek": In(stream.Signature(config.memory.data_bits)), "o": Out(stream.Signature(8)),
            "irq": In(1), "again": In(1), "restarts": Out(1), "busy": Out(1), "failed": Out(1)})

    def elaborate(self, platform):
        m = Module()
        steps = self._program.steps
        m.submodules.steps = memory = Memory(shape=StructLayout({
            "operation": Operation, "address": max(1, *(step.address.bit_length() for step in steps)),
            "value": max(1, *(step.value.bit_length() for step in steps))}), depth=len(steps), init=[
                {"operation": step.operation, "address": step.address, "value": step.value} for step in steps])
        port, number = memory.read_port(), Signal(range(len(steps)))
        m.d.comb += [port.addr.eq(number), self.busy.eq(1)]
        # Bytes to send now, how many of main memory follow them, and from which beat on.
        bits = Signal(max(self._config.memory.data_bits, 8 * HEADER_BYTES), reset_less=True)
        left, more = Signal(range(len(bits) // 8 + 1)), Signal(LENGTH_BITS)
        beat = Signal(self._formats.beat_bits, reset_less=True)
        m.submodules.check = check = CHECK().create()
        m.d.comb += [check.data.eq(self.o.payload), check.valid.eq(self.o.valid & self.o.ready),
                     self.o.payload.eq(bits[:8]), self.o_peek.payload.eq(beat)]

        def send(what, count):
            m.d.sync += [bits.eq(what), left.eq(count)]
            m.next = "send"

        def advance():
            m.d.sync += number.eq(number + 1)
            m.next = "fetch"

        def advance_unless(wrong, then=advance):
            with m.If(wrong & ~self.failed):
                m.d.sync += [number.eq(self._program.error), self.failed.eq(1)]
                m.next = "fetch"
            with m.Else():
                then()

        with m.FSM():
            with m.State("fetch"):
                m.next = "act"
            with m.State("act"):
                self._act(m, port.data, check, send, beat, more)
            with m.State("interrupt"), m.If(self.irq):
                m.d.sync += [self.host.awvalid.eq(1), self.host.wvalid.eq(1)]
                m.next = "write"
            with m.State("write"), m.If(self.host.bvalid):
                with m.If((port.data.operation == Operation.WAIT) & (self.host.bresp == 0)):
                    m.d.sync += self.host.arvalid.eq(1)
                    m.next = "read"
                with m.Else():
                    advance_unless(self.host.bresp != 0)
            with m.State("read"):
                self._read(m, port.data, send, advance_unless)
            with m.State("peek"):
                m.d.comb += self.o_peek.valid.eq(1)
                with m.If(self.o_peek.ready):
                    m.d.sync += beat.eq(beat + 1)
                    m.next = "take"
            with m.State("take"):
                m.d.comb += self.i_peek.ready.eq(1)
                count = Mux(more < self._config.memory.beat_bytes, more, self._config.memory.beat_bytes)
                with m.If(self.i_peek.valid):
                    m.d.sync += more.eq(more - count)
                    send(self.i_peek.payload, count)
            with m.State("send"):
                m.d.comb += self.o.valid.eq(1)
                with m.If(self.o.ready):
                    m.d.sync += [bits.eq(bits >> 8), left.eq(left - 1)]
                    with m.If((left == 1) & (more != 0)):
                        m.next = "peek"
                    with m.Elif(left == 1):
                        advance()
            with m.State("halt"):
                m.d.comb += self.busy.eq(0)
                m.d.comb += self.restarts.eq(self.again)
                with m.If(self.again):
                    m.d.sync += [number.eq(0), self.failed.eq(0)]
                    m.next = "fetch"
        self._add_offers(m, port.data)
        return m

    def _act(self, m, step, check, send, beat, more):
        """Begin a step."""
        host = self.host
        with m.Switch(step.operation):
            with m.Case(Operation.WRITE):
                m.d.sync += [host.awvalid.eq(1), host.wvalid.eq(1)]
                m.next = "write"
            with m.Case(Operation.WAIT):
                m.next = "interrupt"
            with m.Case(Operation.EXPECT, Operation.WORD):
                m.d.sync += host.arvalid.eq(1)
                m.next = "read"
            with m.Case(Operation.FRAME):
                m.d.comb += check.start.eq(1)
                send(step.value, HEADER_BYTES)
            with m.Case(Operation.BYTES):
                m.d.sync += [beat.eq(step.address >> self._formats.low_bits), more.eq(step.value)]
                m.next = "peek"
            with m.Case(Operation.CHECK):
                send(check.crc, CHECK_BYTES)
            with m.Case(Operation.HALT):
                m.next = "halt"

    def _read(self, m, step, send, advance_unless):
        """The reply to a register read."""
        host = self.host
        with m.If(host.rvalid), m.Switch(step.operation):
            with m.Case(Operation.EXPECT):
                advance_unless((host.rresp != 0) | (host.rdata != step.value))
            with m.Case(Operation.WAIT):
                with m.If((host.rdata & (BUSY | HALTED)) == BUSY):
                    m.next = "interrupt"
                with m.Elif((host.rdata & BUSY) != 0):
                    # Units are being reset: no interrupt reports the end of that.
                    m.d.sync += host.arvalid.eq(1)
                with m.Else():
                    advance_unless((host.rresp != 0) | ((host.rdata & FAILED) != 0))
            with m.Case(Operation.WORD):
                advance_unless(host.rresp != 0, lambda: send(host.rdata, WORD_BYTES))

    def _add_offers(self, m, step):
        """AXI pins that depend on the step; an offer ends with its transfer."""
        host, waits = self.host, step.operation == Operation.WAIT
        m.d.comb += [
            host.awaddr.eq(Mux(waits, INTERRUPT, step.address)), host.araddr.eq(step.address),
            host.wdata.eq(Mux(waits, ACKNOWLEDGE, step.value)), host.wstrb.eq(-1), host.awprot.eq(UNPRIVILEGED),
            host.arprot.eq(UNPRIVILEGED), host.bready.eq(1), host.rready.eq(1)]
        for channel in "aw", "w", "ar":
            valid, ready = getattr(host, f"{channel}valid"), getattr(host, f"{channel}ready")
            with m.If(valid & ready):
                m.d.sync += valid.eq(0)
