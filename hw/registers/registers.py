"""Registers: an AXI4-Lite subordinate made from a table."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hw.registers.axi_lite_signature import DATA_BITS, AxiLiteSignature
from hw.registers.register import WORD_BYTES, Access, Register, addresses

__all__ = ["OKAY", "SLVERR", "Registers"]

OKAY, SLVERR = 0, 2


class Registers(wiring.Component):
    """An AXI4-Lite subordinate with the registers of a table, and a window onto others.

    An access to an address without a register, or a write to a read-only register, is answered with SLVERR; it changes
    nothing and reads as 0. The low two bits of an address are ignored. Bytes without a strobe keep their value; of a
    command they are 0, and a write without strobes is none.

    Parameters
    ----------
    registers
        The table; names are unique, addresses begin at 0.
    memory_bits
        Of addresses of main memory.
    address_bits
        Of ``host``. Addresses whose highest bit is set belong to the window, which is read-only.

    Members
    -------
    host : In, `AxiLiteSignature`
        The host.
    <name> : In(width), Out(width), or Out, stream of the written value, always ready
        One for each register, by its access: READ, WRITE, or COMMAND and CONTROL. Of CONTROL there is ``<name>_value``
        too, In(width), which the host reads.
    o_window : Out, stream of the number of a word
        A read in the window. One at a time.
    i_window : In, stream of 32 bits
        The word.

    Timing
    ------
    Latency: ``2`` cycles from a read's address to its data outside the window, and from the later one of a write's
    address and data to its answer. A write changes its register, or is a command, in the cycle before the answer. Reads
    and writes are independent; one of each in flight, and the next one waits inside until the answer has been taken.

    Raises
    ------
    ValueError
        The registers do not fit below the window.
    """

    latency = 2

    def __init__(self, registers: tuple[Register, ...], *, address_bits: int, memory_bits: int = 64):
        self._registers, self._addresses = tuple(registers), addresses(registers)
        end = WORD_BYTES * sum(register.words for register in self._registers)
        if end > 1 << address_bits - 1:
            raise ValueError(f"Registers must end at {1 << address_bits - 1}, not {end}")
        self._word_bits, self._memory_bits = address_bits - 3, memory_bits
        members = {}
        for register in self._registers:
            if register.access is Access.READ:
                members[register.name] = In(register.width)
            elif register.access is Access.WRITE:
                members[register.name] = Out(register.width, init=register.reset)
            else:
                members[register.name] = Out(stream.Signature(register.width, always_ready=True))
                if register.access is Access.CONTROL:
                    members[f"{register.name}_value"] = In(register.width)
        super().__init__({
            "host": In(AxiLiteSignature(address_bits=address_bits)), **members,
            "o_window": Out(stream.Signature(self._word_bits)), "i_window": In(stream.Signature(DATA_BITS))})

    def elaborate(self, platform):
        m = Module()
        self._add_writes(m)
        self._add_reads(m)
        return m

    def _words(self, register):
        """By word: its address, and its bits of the register."""
        first = self._addresses[register.name] // WORD_BYTES
        return [(first + k, slice(DATA_BITS * k, min(DATA_BITS * (k + 1), register.width)))
                for k in range(register.words)]

    def _add_writes(self, m):
        host = self.host
        # Address and data arrive in any order.
        address, data, strobe = Signal(len(host.awaddr)), Signal(DATA_BITS), Signal(WORD_BYTES)
        addressed, given, acts = Signal(), Signal(), Signal()
        m.d.comb += [host.awready.eq(~addressed), host.wready.eq(~given),
                     acts.eq(addressed & given & (~host.bvalid | host.bready))]
        with m.If(acts):
            m.d.sync += [addressed.eq(0), given.eq(0)]
        with m.If(host.awvalid & host.awready):
            m.d.sync += [addressed.eq(1), address.eq(host.awaddr)]
        with m.If(host.wvalid & host.wready):
            m.d.sync += [given.eq(1), data.eq(host.wdata), strobe.eq(host.wstrb)]
        known, mask = Signal(), Signal(DATA_BITS)
        m.d.comb += mask.eq(Cat(bit.replicate(8) for bit in strobe))
        with m.Switch(address[2:]):
            for register in self._registers:
                for number, bits in self._words(register):
                    with m.Case(number):
                        target = getattr(self, register.name)
                        if register.access is Access.WRITE:
                            written, few = Signal(len(target[bits])), Signal()
                            ones = register.ones(self._memory_bits) >> bits.start & (1 << DATA_BITS) - 1
                            m.d.comb += [
                                written.eq((target[bits] & ~mask) | (data & mask)),
                                few.eq(1 if register.most is None else written <= register.most),
                                known.eq(few & ((data & mask & (ones ^ (1 << DATA_BITS) - 1)) == 0))]
                            with m.If(acts & known):
                                m.d.sync += target[bits].eq(written)
                        elif register.access in (Access.COMMAND, Access.CONTROL):
                            m.d.comb += [known.eq(1), target.valid.eq(acts & strobe.any())]
        for register in self._registers:
            if register.access in (Access.COMMAND, Access.CONTROL):
                m.d.comb += getattr(self, register.name).payload.eq(data & mask)
        with m.If(host.bready):
            m.d.sync += host.bvalid.eq(0)
        with m.If(acts):
            m.d.sync += [host.bvalid.eq(1), host.bresp.eq(Mux(known, OKAY, SLVERR))]

    def _add_reads(self, m):
        host = self.host
        address, addressed, requested = Signal(len(host.araddr)), Signal(), Signal()
        known, word, window, free, acts = Signal(), Signal(DATA_BITS), Signal(), Signal(), Signal()
        m.d.comb += [
            host.arready.eq(~addressed), window.eq(address[-1]), free.eq(~host.rvalid | host.rready),
            self.o_window.valid.eq(addressed & window & ~requested), self.o_window.payload.eq(address[2:]),
            self.i_window.ready.eq(addressed & window & free),
            acts.eq(addressed & free & (~window | self.i_window.valid))]
        with m.If(host.arvalid & host.arready):
            m.d.sync += [addressed.eq(1), requested.eq(0), address.eq(host.araddr)]
        with m.If(self.o_window.valid & self.o_window.ready):
            m.d.sync += requested.eq(1)
        with m.If(acts):
            m.d.sync += addressed.eq(0)
        with m.Switch(address[2:]):
            for register in self._registers:
                for number, bits in self._words(register):
                    with m.Case(number):
                        m.d.comb += known.eq(1)
                        if register.access is Access.CONTROL:
                            m.d.comb += word.eq(getattr(self, f"{register.name}_value")[bits])
                        elif register.access is not Access.COMMAND:
                            m.d.comb += word.eq(getattr(self, register.name)[bits])
        with m.If(window):
            m.d.comb += [known.eq(1), word.eq(self.i_window.payload)]
        with m.If(host.rready):
            m.d.sync += host.rvalid.eq(0)
        with m.If(acts):
            m.d.sync += [host.rvalid.eq(1), host.rdata.eq(word), host.rresp.eq(Mux(known, OKAY, SLVERR))]
