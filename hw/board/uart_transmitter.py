"""UART transmitter: bytes onto a serial line."""

from amaranth.hdl import Cat, Const, Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hw.lib.validate import check_integer

__all__ = ["UartTransmitter"]

# A start bit, eight of data, the lowest first, and a stop bit.
FRAME_BITS = 10


class UartTransmitter(wiring.Component):
    """Sends bytes: 8 data bits, no parity, one stop bit.

    Parameters
    ----------
    divisor
        Cycles of a bit, at least 1.

    Members
    -------
    i : In, stream of bytes
        Bytes.
    tx : Out(1)
        The line, 1 while idle.

    Timing
    ------
    Latency: ``1`` cycle to the start bit. A byte every ten bits, without a gap; stalls ``i`` meanwhile.

    Raises
    ------
    TypeError
        The divisor is no integer.
    ValueError
        The divisor is out of range.
    """

    latency = 1

    def __init__(self, *, divisor: int):
        check_integer("Divisor", divisor, minimum=1)
        self._divisor = divisor
        super().__init__({"i": In(stream.Signature(8)), "tx": Out(1, init=1)})

    def elaborate(self, platform):
        m = Module()
        bits, left, cycles = Signal(FRAME_BITS, init=-1), Signal(range(FRAME_BITS + 1)), Signal(range(self._divisor))
        ends = cycles == self._divisor - 1
        m.d.comb += [self.tx.eq(bits[0]), self.i.ready.eq((left == 0) | ((left == 1) & ends))]
        m.d.sync += cycles.eq(cycles + 1)
        with m.If(ends & (left != 0)):
            m.d.sync += [bits.eq(Cat(bits[1:], 1)), left.eq(left - 1), cycles.eq(0)]
        with m.If(self.i.valid & self.i.ready):
            m.d.sync += [bits.eq(Cat(Const(0, 1), self.i.payload, 1)), left.eq(FRAME_BITS), cycles.eq(0)]
        return m
