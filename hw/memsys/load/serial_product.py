"""Serial product: a product of two numbers, bit by bit, where there is time."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from hw.lib.validate import check_integer

__all__ = ["SerialProduct"]


class SerialProduct(wiring.Component):
    """``sum = addend + a b``, a bit of b per cycle from the lowest one to the highest 1.

    Parameters
    ----------
    a, b, addend
        Bits of the operands, at least 1 each.

    Members
    -------
    i : In, stream of ``a``, ``b``, ``addend``
        Operands.
    o : Out, stream of the sum
        As many bits as the largest sum has.

    Timing
    ------
    Latency: ``1`` cycle and one for each bit of b up to its highest 1. One product in flight; stalls with ``o``.

    Raises
    ------
    TypeError
        A number of bits is no integer.
    ValueError
        A number of bits is out of range.
    """

    def __init__(self, *, a: int, b: int, addend: int = 1):
        for name, value in ("A", a), ("B", b), ("Addend", addend):
            check_integer(name, value, minimum=1)
        self._b = b
        most = ((1 << a) - 1) * ((1 << b) - 1) + (1 << addend) - 1
        super().__init__({"i": In(stream.Signature(StructLayout({"a": a, "b": b, "addend": addend}))),
                          "o": Out(stream.Signature(most.bit_length()))})
        self.latency = 1 + b

    def elaborate(self, platform):
        m = Module()
        # ``more``: b has a 1 yet, known a step ahead.
        busy, more, b = Signal(), Signal(reset_less=True), Signal(self._b, reset_less=True)
        a, total = (Signal.like(self.o.payload, reset_less=True, name=name) for name in ("a", "total"))
        m.d.comb += [self.i.ready.eq(~busy), self.o.valid.eq(busy & ~more), self.o.payload.eq(total)]
        with m.If(self.i.ready):
            m.d.sync += [busy.eq(self.i.valid), a.eq(self.i.payload.a), b.eq(self.i.payload.b),
                         more.eq(self.i.payload.b != 0), total.eq(self.i.payload.addend)]
        with m.Elif(more):
            m.d.sync += [a.eq(a << 1), b.eq(b >> 1), more.eq(b[1:].any()), total.eq(total + Mux(b[0], a, 0))]
        with m.Elif(self.o.ready):
            m.d.sync += busy.eq(0)
        return m
