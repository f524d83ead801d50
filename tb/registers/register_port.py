"""Registers with the channels of their port as streams, and registers of the machine that change in every cycle."""

from amaranth.hdl import Assert, Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from hw.registers.register import Access, Register
from hw.registers.registers import Registers
from tb.axi.axi_lite_protocol import AxiLiteProtocol
from tb.axi.protocol_checker import ProtocolChecker

__all__ = ["RegisterPort"]

# The machine's register of a number grows by this and twice the number.
STEP = 0x9E3779B97F4A7C15

# A manager's channels and a subordinate's, each with its payload.
GIVEN = {"aw": ("addr", "prot"), "w": ("data", "strb"), "ar": ("addr", "prot")}
ANSWERED = {"b": ("resp",), "r": ("data", "resp")}


class RegisterPort(wiring.Component):
    """`Registers` for `tb.lib.schedules.ScheduleBench`. A violation of a subordinate's rules ends the simulation.

    Parameters
    ----------
    registers, address_bits, memory_bits
        As of `Registers`.

    Members
    -------
    aw, w, ar : In, streams of the channel's payload
        From the manager.
    b, r : Out, streams of the channel's payload
        To it.
    <name> : Out, stream of the written value, always ready
        Commands.
    o_window : Out, stream of the number of a word
        Reads in the window.
    i_window : In, stream of 32 bits
        Their words.
    """

    def __init__(self, registers: tuple[Register, ...], *, address_bits: int, memory_bits: int):
        self._table = registers
        self._dut = Registers(registers, address_bits=address_bits, memory_bits=memory_bits)
        self._protocol = AxiLiteProtocol(address_bits)
        host = self._dut.host
        members = {}
        for flow, channels in (In, GIVEN), (Out, ANSWERED):
            for channel, pins in channels.items():
                members[channel] = flow(stream.Signature(StructLayout(
                    {pin: len(getattr(host, channel + pin)) for pin in pins})))
        members |= {one.name: Out(stream.Signature(one.width, always_ready=True)) for one in registers
                    if one.access in (Access.COMMAND, Access.CONTROL)}
        super().__init__({**members, **{name: self._dut.signature.members[name] for name in ("o_window", "i_window")}})

    @staticmethod
    def machine(registers: tuple[Register, ...], cycle: int) -> dict[str, int]:
        """What the machine's registers are in a cycle, the first one after a reset is 1."""
        return {one.name: (cycle - 1) * (STEP + 2 * number) % (1 << one.width)
                for number, one in enumerate(registers) if one.access in (Access.READ, Access.CONTROL)}

    def elaborate(self, platform):
        """The registers with all channels connected."""
        m = Module()
        m.submodules.dut, m.submodules.checker = dut, checker = self._dut, ProtocolChecker(self._protocol)
        checker.watch(m, dut.host)
        # The bench offers items right after a reset.
        m.d.sync += [Assert(~checker.violated[rule]) for rule in self._protocol.subordinate]
        for channels, manager in (GIVEN, True), (ANSWERED, False):
            for channel, pins in channels.items():
                mine, host = getattr(self, channel), dut.host
                pairs = [(getattr(host, f"{channel}{pin}"), mine.payload[pin]) for pin in pins]
                pairs.append((getattr(host, f"{channel}valid"), mine.valid))
                m.d.comb += [theirs.eq(ours) if manager else ours.eq(theirs) for theirs, ours in pairs]
                ready = getattr(host, f"{channel}ready")
                m.d.comb += mine.ready.eq(ready) if manager else ready.eq(mine.ready)
        for number, one in enumerate(self._table):
            if one.access in (Access.READ, Access.CONTROL):
                value = Signal(one.width, name=f"machine_{one.name}")
                m.d.sync += value.eq(value + STEP + 2 * number)
                read = one.name if one.access is Access.READ else f"{one.name}_value"
                m.d.comb += getattr(dut, read).eq(value)
            if one.access in (Access.COMMAND, Access.CONTROL):
                wiring.connect(m, getattr(dut, one.name), wiring.flipped(getattr(self, one.name)))
        for name in "o_window", "i_window":
            wiring.connect(m, getattr(dut, name), wiring.flipped(getattr(self, name)))
        return m
