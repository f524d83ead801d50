"""Reciprocal: the only division, once per patch."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

__all__ = ["Reciprocal"]

# Bits that a stage makes, one per cycle.
STEPS = 4


class Reciprocal(wiring.Component):
    """``floor(2^(2 width - 1) / mantissa)``, at most 2^``width`` - 1, for mantissas whose leading bit is 1.

    A chain of stages of restoring division, each of which works on an item for four cycles.

    Parameters
    ----------
    width
        Bits of the mantissa and of the result.
    tag
        Shape of the sideband data.

    Members
    -------
    i : In, stream of ``tag``, ``mantissa``, always ready
        Mantissas; at least four cycles apart.
    o : Out, stream of ``tag``, ``inverse``, always ready
        Reciprocals.

    Timing
    ------
    Latency: ``4 * ((width + 3) // 4)`` cycles. An item every four cycles; nothing stalls.

    Golden counterpart: `golden.engine.icu.reciprocal.reciprocal`.
    """

    def __init__(self, *, width: int, tag):
        self._bits, self._tag = width, tag
        self._stages = -(-width // STEPS)
        super().__init__({
            "i": In(stream.Signature(StructLayout({"tag": tag, "mantissa": width}), always_ready=True)),
            "o": Out(stream.Signature(StructLayout({"tag": tag, "inverse": width}), always_ready=True))})
        self.latency = STEPS * self._stages

    def elaborate(self, platform):
        m = Module()
        bits = self._bits
        # Before the first step the remainder is half the smallest mantissa's double; from the smallest mantissa it gets
        # a one in every step, which is the largest result.
        valid, tag, divisor = self.i.valid, self.i.payload.tag, self.i.payload.mantissa
        remainder, quotient = 1 << bits - 1, None
        for _ in range(self._stages):
            busy = Signal(STEPS)
            kept_tag = Signal(self._tag, reset_less=True)
            kept_divisor, kept_remainder = (Signal(bits, reset_less=True) for _ in range(2))
            made = STEPS + (0 if quotient is None else len(quotient))
            kept_quotient = Signal(made, reset_less=True)
            m.d.sync += busy.eq(Cat(valid, busy))
            now = {name: Mux(valid, new, old) for name, new, old in (
                ("divisor", divisor, kept_divisor), ("remainder", remainder, kept_remainder),
                ("quotient", 0 if quotient is None else quotient, kept_quotient))}
            doubled = Cat(0, now["remainder"][:bits])
            rest = doubled - now["divisor"]
            fits = ~rest[bits + 1]
            m.d.sync += [kept_divisor.eq(now["divisor"]), kept_remainder.eq(Mux(fits, rest, doubled)),
                         kept_quotient.eq(Cat(fits, now["quotient"]))]
            with m.If(valid):
                m.d.sync += kept_tag.eq(tag)
            valid, tag, divisor, remainder, quotient = busy[-1], kept_tag, kept_divisor, kept_remainder, kept_quotient
        m.d.comb += [self.o.valid.eq(valid), self.o.payload.tag.eq(tag), self.o.payload.inverse.eq(quotient[-bits:])]
        return m
