import numpy as np
import pytest
from amaranth.hdl import Cat, Module, signed, unsigned
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out
from amaranth.sim import Simulator

from golden.fixed import bit_length, limbs
from golden.fixed import round_shift as golden_round_shift
from hw.lib import fixed
from hw.lib.pipeline import Pipeline
from tb.lib.payload import pack, unpack

COUNT = 300
WIDTHS = [2, 3, 17, 18, 19, 36, 60]


class Operator(wiring.Component):
    """One operator between two streams.

    Parameters
    ----------
    operands, results
        Shapes.
    apply
        From the pipeline and the staged operands to the list of staged results.
    """

    def __init__(self, operands, results, apply):
        operands, results = (StructLayout({f"_{k}": shape for k, shape in enumerate(shapes)})
                             for shapes in (operands, results))
        super().__init__({"i": In(stream.Signature(operands, always_ready=True)),
                          "o": Out(stream.Signature(results, always_ready=True))})
        self._pipeline = Pipeline(self.i, self.o)
        values = [self._pipeline.input(self.i.payload[name]) for name, _ in operands]
        for (name, _), value in zip(results, apply(self._pipeline, *values), strict=True):
            self._pipeline.output(self.o.payload[name], value)
        self.latency = self._pipeline.latency

    def elaborate(self, platform):
        m = Module()
        self._pipeline.add_to(m)
        return m


def run(operands, results, apply, columns):
    """What the operator makes of rows of operands, given one per cycle: a column for each result, and the latency."""
    operator = Operator(operands, results, apply)
    shape, came = operator.i.payload.shape(), []

    async def drive(ctx):
        for cycle in range(len(columns[0]) + operator.latency):
            if cycle < len(columns[0]):
                row = {f"_{k}": int(column[cycle]) for k, column in enumerate(columns)}
                ctx.set(operator.i.payload.as_value(), pack(shape, row))
            ctx.set(operator.i.valid, cycle < len(columns[0]))
            assert ctx.get(operator.o.valid) == (cycle >= operator.latency)
            if cycle >= operator.latency:
                came.append(unpack(operator.o.payload.shape(), ctx.get(operator.o.payload.as_value())))
            await ctx.tick()

    simulator = Simulator(operator)
    simulator.add_clock(1e-8)
    simulator.add_testbench(drive)
    simulator.run()
    return [[row[f"_{k}"] for row in came] for k in range(len(results))], operator.latency


def draw(shape, seed=1, *, least=None):
    """Integers of all sizes that a shape can hold, the extreme ones first."""
    generator = np.random.default_rng(seed)
    bits = shape.width - shape.signed
    high = (1 << bits) - 1
    low = -high - 1 if shape.signed else 0
    low = low if least is None else least
    sizes = generator.integers(0, bits + 1, COUNT)
    values = generator.integers(0, 1 << 62, COUNT) >> (62 - sizes)
    if shape.signed:
        values = np.where(generator.integers(0, 2, COUNT), values, -values)
    hard = np.array([0, 1, high, high - 1, low, low + 1, high >> 1, (high >> 1) + 1])
    return np.clip(np.concatenate([hard, values]), low, high)


def check(got, expected):
    """Element for element."""
    assert got == np.asarray(expected).tolist()


@pytest.mark.parametrize(("width", "by"),
                         [(width, by) for width in WIDTHS for by in (0, 1, 2, 17, 58) if by < width - 1])
def test_round_shift(width, by):
    values = draw(signed(width))
    # All halves, of both signs, are among them.
    halves = (values >> by << by) + (1 << by >> 1)
    values = np.concatenate([values, np.where(halves < 1 << width - 1, halves, 0)])
    (came,), _ = run([signed(width)], [signed(width + 1)],
                     lambda p, x: [p.combine(lambda x: fixed.round_shift(x, by), x)], [values])
    check(came, golden_round_shift(values, by))


@pytest.mark.parametrize("width", WIDTHS)
def test_magnitude_and_sign(width):
    values = draw(signed(width), least=1 - (1 << width - 1))

    def apply(p, x):
        size = p.combine(fixed.magnitude, x)
        assert len(size.value) == width - 1
        return [size, p.combine(lambda size, x: fixed.with_sign(size, x[-1]), size, x)]

    (size, back), _ = run([signed(width)], [unsigned(width - 1), signed(width)], apply, [values])
    check(size, np.abs(values))
    check(back, values)


@pytest.mark.parametrize("width", WIDTHS)
@pytest.mark.parametrize("bits", [2, 18])
def test_split_limbs(width, bits):
    values = draw(signed(width))

    def apply(p, x):
        high, low = p.combine(lambda x: Cat(*fixed.split_limbs(x, bits)), x), p.combine(
            lambda x: fixed.split_limbs(x, bits)[1], x)
        size = len(high.value) - len(low.value)
        return [p.combine(lambda both: both[:size].as_signed(), high), low]

    (high, low), _ = run([signed(width)], [signed(width), signed(bits)], apply, [values])
    expected = limbs(values, bits) if width > bits else (0 * values, values)
    check(high, expected[0])
    check(low, expected[1])


@pytest.mark.parametrize("width", WIDTHS)
def test_normalise_counts_leading_zeros(width):
    values = draw(unsigned(width))
    steps = max(1, (width - 1).bit_length())

    def apply(p, x):
        (moved,), by = fixed.normalise(p, width, [x])
        return [moved, by]

    (moved, by), latency = run([unsigned(width)], [unsigned(width), unsigned(steps)], apply, [values])
    expected = np.where(values == 0, (1 << steps) - 1, width - bit_length(values))
    check(by, expected)
    check(moved, np.where(values == 0, 0, values << np.where(values == 0, 0, expected)))
    assert latency == steps


def test_normalise_together():
    width = 24
    a, b, c = (draw(unsigned(bits), seed) for seed, bits in enumerate((24, 20, 3)))

    def apply(p, *operands):
        moved, by = fixed.normalise(p, width, operands)
        return [*moved, by]

    (*moved, by), _ = run([unsigned(24), unsigned(20), unsigned(3)], [unsigned(24)] * 3 + [unsigned(5)], apply,
                          [a, b, c])
    longest = bit_length(a | b | c)
    expected = np.where(longest == 0, 31, width - longest)
    check(by, expected)
    for got, values in zip(moved, (a, b, c), strict=True):
        check(got, values << np.where(longest == 0, 0, expected))


@pytest.mark.parametrize("width", [17, 36, 60])
@pytest.mark.parametrize("shape", [signed, unsigned])
def test_shifts(width, shape):
    steps = 6
    values, by = draw(shape(width)), np.random.default_rng(3).integers(0, 64, COUNT + 8)
    (right, left), latency = run(
        [shape(width), unsigned(steps)], [shape(width), unsigned(width)],
        lambda p, x, by: [fixed.shift_right(p, x, by, width), fixed.shift_left(p, x, by, width)], [values, by])
    check(right, values >> by)
    assert left == [int(value) << int(places) & (1 << width) - 1 for value, places in zip(values, by, strict=True)]
    assert latency == steps // fixed.LEVELS


def test_small_product():
    a, b = np.meshgrid(np.arange(-8, 8), draw(signed(18)))
    (came,), latency = run([signed(4), signed(18)], [signed(24)], lambda p, a, b: [fixed.small_product(p, a, b)],
                           [a.ravel(), b.ravel()])
    check(came, (a * b).ravel())
    assert latency == 3


@pytest.mark.parametrize("widths", [(4, 4), (3, 36), (36, 5)])
def test_add_or_subtract(widths):
    a, b = (draw(signed(width), seed) for seed, width in enumerate(widths))
    chosen = np.random.default_rng(5).integers(0, 2, len(a))

    def apply(p, a, b, subtract):
        result = p.combine(fixed.add_or_subtract, a, b, subtract)
        assert len(result.value) == max(widths) + 1
        return [result]

    (came,), _ = run([*map(signed, widths), unsigned(1)], [signed(max(widths) + 1)], apply, [a, b, chosen])
    check(came, np.where(chosen, a - b, a + b))


@pytest.mark.parametrize("count", [1, 2, 3, 5, 8])
def test_of_several(count):
    shapes = [signed(12 + k) for k in range(count)]
    columns = [draw(shape, seed) for seed, shape in enumerate(shapes)]
    (most, least, total), latency = run(
        shapes, [signed(24)] * 3,
        lambda p, *x: [fixed.extreme(p, x, largest=True), fixed.extreme(p, x, largest=False), fixed.total(p, x)],
        columns)
    check(most, np.max(columns, axis=0))
    check(least, np.min(columns, axis=0))
    check(total, np.sum(columns, axis=0))
    assert latency == max(1, (count - 1).bit_length())
