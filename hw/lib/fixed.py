"""Fixed-point operators, bit for bit those of `golden.engine.lib.fixed`: functions of values, steps of a `Pipeline`."""

from collections.abc import Sequence
from itertools import pairwise

from amaranth.hdl import Array, Cat, Const, Mux, Value

from hw.lib.pipeline import Pipeline, Staged

__all__ = ["add_or_subtract", "extreme", "magnitude", "normalise", "round_shift", "serial_product", "shift_left",
           "shift_right", "small_product", "split_limbs", "total", "with_sign"]

# Multiplexers between two registers of a shifter.
LEVELS = 2


def magnitude(value: Value) -> Value:
    """Absolute value of a signed one that is never the most negative number: one bit less."""
    negative = value[-1]
    return ((value.as_signed() ^ negative.as_signed()).as_unsigned() + negative)[:len(value) - 1]


def with_sign(magnitude: Value, negative: Value) -> Value:
    """The signed value of a magnitude, one bit wider."""
    flipped = (Cat(magnitude, 0).as_signed() ^ negative.as_signed()).as_unsigned()
    return (flipped + negative)[:len(flipped)].as_signed()


def round_shift(value: Value, by: int) -> Value:
    """A signed value / 2^``by`` to the nearest integer, half away from zero: one addition."""
    if by == 0:
        return value
    # Of a negative value half is rounded down, which is away from zero.
    total = value + Mux(value[-1], Const((1 << by - 1) - 1, by), Const(1 << by - 1, by))
    return (total >> by).as_signed()[:len(value) - by + 1].as_signed()


def split_limbs(value: Value, bits: int) -> tuple[Value, Value]:
    """(h, l) with ``value = h 2^bits + l`` and ``-2^(bits-1) <= l < 2^(bits-1)``: two balanced limbs, both signed.

    A value of at most ``bits`` bits has h = 0. Otherwise h has one bit more than are above ``bits``.
    """
    if len(value) <= bits:
        return Const(0, 1).as_signed(), value.as_signed()
    low = value[:bits].as_signed()
    high = value[bits:].as_signed() + value[bits - 1]
    return high[:len(value) - bits + 1].as_signed(), low


def normalise(pipeline: Pipeline, width: int, operands: Sequence[Staged]) -> tuple[list[Staged], Staged]:
    """Unsigned values shifted left together until one of them has its leading one at bit ``width`` - 1.

    Returns
    -------
    The shifted values, and by how much; of zeros it is the largest shift, 2^k - 1 of at least ``width`` - 1.
    """
    shifts = [min(1 << step, width) for step in reversed(range(max(1, (width - 1).bit_length())))]
    operands = [pipeline.combine(lambda value: Cat(value, Const(0, max(0, width - len(value))))[:width], operand)
                for operand in operands]

    def clear(values, count):
        return ~Cat(value[width - count:] for value in values).any()

    def move(empty, value, count):
        return Mux(empty, (value << count)[:width], value)

    # Whether a step moves is found with the step before it, for both that this one may do: the test of all leading
    # bits in front of the multiplexers is too long for one cycle.
    empty = pipeline.register(lambda *values: clear(values, shifts[0]), *operands)
    by = [empty]
    for now, following in pairwise([*shifts, None]):
        def test(empty, *values, now=now, following=following):
            return Mux(empty, clear([move(1, value, now) for value in values], following), clear(values, following))

        if following is not None:
            by.append(pipeline.register(test, empty, *operands))
        operands = [pipeline.register(lambda empty, value, now=now: move(empty, value, now), empty, operand)
                    for operand in operands]
        empty = by[-1]
    return operands, pipeline.combine(lambda *bits: Cat(*reversed(bits)), *by)


def shift_left(pipeline: Pipeline, value: Staged, by: Staged, width: int) -> Staged:
    """``value 2^by``, the low ``width`` bits; keeps the sign of signed values."""
    return _shift(pipeline, value, by, width, lambda value, count: value << count)


def shift_right(pipeline: Pipeline, value: Staged, by: Staged, width: int) -> Staged:
    """``value / 2^by``, cut off downwards."""
    return _shift(pipeline, value, by, width, lambda value, count: value >> count)


def _shift(pipeline, value, by, width, move):
    is_signed = Value.cast(value.value).shape().signed
    for bit in range(len(by.value)):
        def step(value, by, bit=bit):
            moved = Mux(by[bit], move(value, min(1 << bit, width)), value)[:width]
            return moved.as_signed() if is_signed else moved

        value = pipeline.register(step, value, by) if bit % LEVELS == LEVELS - 1 else pipeline.combine(step, value, by)
    if len(by.value) % LEVELS:
        value = pipeline.delay(value, 1)
    return value


def small_product(pipeline: Pipeline, a: Staged, b: Staged) -> Staged:
    """``a b`` of signed values without a multiplier, for a short ``a``: its bits choose what is added."""
    def row(a, b, bit):
        term = Mux(a[bit], -b if bit == len(a) - 1 else b, 0)
        return (term << bit).as_signed()

    return total(pipeline, [pipeline.register(lambda a, b, bit=bit: row(a, b, bit), a, b)
                            for bit in range(len(a.value))])


def serial_product(pipeline: Pipeline, a: Staged, b: int) -> Staged:
    """``a b`` of a signed value and a number above 0 without a multiplier: a bit of the number per cycle."""
    count = b.bit_length()
    bits = Array(Const(b >> bit & 1, 1) for bit in reversed(range(count)))
    width = len(a.value) + count

    def row(number, total, a):
        return ((total << 1) + Mux(bits[number], a, 0))[:width].as_signed(), a

    return pipeline.rounds(row, count, pipeline.constant(Const(0, width).as_signed()), a)[0]


def add_or_subtract(a: Value, b: Value, subtract: Value) -> Value:
    """``a + b`` or ``a - b`` of signed values by one adder, whose carry comes from a bit below both."""
    width = max(len(a), len(b)) + 1
    a, b = a.as_signed(), b.as_signed() ^ subtract.as_signed()
    return (Cat(subtract, a).as_signed() + Cat(subtract, b).as_signed())[1:width + 1].as_signed()


def extreme(pipeline: Pipeline, values: Sequence[Staged], *, largest: bool) -> Staged:
    """The largest or the smallest of some values, two by two, with a register behind each comparison."""
    def better(a, b):
        chosen = Mux((a > b) if largest else (a < b), a, b)
        return chosen.as_signed() if Value.cast(a).shape().signed or Value.cast(b).shape().signed else chosen

    values = list(values)
    while len(values) > 1:
        pairs = [pipeline.register(better, *values[k:k + 2]) for k in range(0, len(values) - 1, 2)]
        values = pairs + values[len(values) & ~1:]
    return values[0]


def total(pipeline: Pipeline, terms: Sequence[Staged]) -> Staged:
    """The sum of some values, two by two, with a register behind each addition."""
    terms = list(terms)
    while len(terms) > 1:
        pairs = [pipeline.register(lambda a, b: a + b, *terms[k:k + 2]) for k in range(0, len(terms) - 1, 2)]
        terms = pairs + terms[len(terms) & ~1:]
    return terms[0]
