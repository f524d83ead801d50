"""Inverse distance: 1/t as an unsigned float that compares as an integer; larger is nearer, 0 is no hit."""

from amaranth.hdl import Cat, Mux, Value
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config, Numbers
from hw.icu.icu_formats import IcuFormats
from hw.icu.icu_tables import SMALLEST
from hw.lib.fixed import normalise, small_product, split_limbs, total
from hw.lib.pipeline import OPERAND, Pipeline, Staged

__all__ = ["InverseDistance", "encode", "value_bits"]



def value_bits(numbers: Numbers) -> int:
    """Bits of m . d, when it is positive: three products of magnitudes below 2^``mantissa_bits`` and at most one."""
    return numbers.mantissa_bits + numbers.direction_fraction + 2


def encode(pipeline: Pipeline, value: Staged, exponent: Staged, numbers: Numbers, *, up: bool = False) -> Staged:
    """``value 2^exponent`` in the stored format, truncated or rounded ``up``.

    Parameters
    ----------
    value
        Signed; positive ones have at most `value_bits` bits.
    exponent
        Signed.

    Returns
    -------
    `Formats.inverse`; `SMALLEST` for what is not positive or too small, the largest number for what is too large.

    Golden counterpart: `golden.engine.icu.inverse_distance.encode`.
    """
    width, fraction = value_bits(numbers), numbers.fraction_bits
    positive = pipeline.combine(lambda value: (value > 0), value)
    (leading,), empty = normalise(pipeline, width, [pipeline.combine(lambda value: value[:width], value)])
    biased = pipeline.register(lambda exponent, empty: exponent + (width - 1 + numbers.inverse_bias) - empty,
                              exponent, empty)
    kept = width - 1 - fraction

    def joined(biased, leading):
        lost = leading[:kept].any() if up else 0
        return (Cat(leading[kept:width - 1], biased).as_signed() + lost)[:fraction + len(biased)].as_signed()

    key = pipeline.register(joined, biased, leading)
    most = numbers.inverse.high

    def clipped(key, positive):
        above = key[fraction:].as_signed() >= 1 << numbers.exponent_bits
        return Mux(~positive | (key < SMALLEST), SMALLEST, Mux(above, most, key))[:numbers.inverse.width]

    return pipeline.register(clipped, key, positive)


class InverseDistance(wiring.Component):
    """``1/t = m . d`` in the stored format.

    The low limb of each component of m has a DSP block; the high one is short enough for adders.

    Parameters
    ----------
    config
        The configuration.
    tag
        Shape of the sideband data.

    Members
    -------
    i : In, stream of ``tag``, ``direction``, ``mantissa``, ``exponent``, always ready
        A ray, and mantissa (`IcuFormats.mantissa_vector`) and exponent of the plane factor.
    o : Out, stream of ``tag``, ``inverse``, always ready
        `Formats.inverse`.

    Timing
    ------
    Latency: ``max(product_registers, 1 + bits(mantissa_bits - 17)) + bits(mantissa_bits + direction_fraction + 1) + 7``
    cycles, ``bits(n)`` those of the number n. One ray per cycle; nothing stalls.

    Golden counterpart: `golden.engine.icu.inverse_distance.inverse_distance`.
    """

    def __init__(self, *, config: Config, tag):
        formats, numbers = IcuFormats(config), config.numbers
        super().__init__({
            "i": In(stream.Signature(StructLayout({
                "tag": tag, "direction": formats.direction_vector, "mantissa": formats.mantissa_vector,
                "exponent": formats.factor_exponent}), always_ready=True)),
            "o": Out(stream.Signature(StructLayout({"tag": tag, "inverse": formats.inverse}), always_ready=True))})
        self._pipeline = pipeline = Pipeline(self.i, self.o)
        given = self.i.payload
        lows, highs = [], []
        for axis in range(3):
            direction, mantissa = pipeline.input(given.direction[axis]), pipeline.input(given.mantissa[axis])
            high, low = pipeline.register(lambda value: tuple(map(Value.cast, split_limbs(value, OPERAND))), mantissa)
            lows.append(pipeline.product(low, direction, registers=config.icu.product_registers))
            highs.append(small_product(pipeline, high, direction))
        low, high = total(pipeline, lows), total(pipeline, highs)
        value = pipeline.register(lambda low, high: low + (high << OPERAND), low, high)
        exponent = pipeline.combine(lambda value: value - numbers.direction_fraction, pipeline.input(given.exponent))
        pipeline.output(self.o.payload.inverse, encode(pipeline, value, exponent, numbers))
        pipeline.output(self.o.payload.tag, pipeline.input(given.tag))
        self.latency = pipeline.latency

    def elaborate(self, platform):
        return self._pipeline.module()
