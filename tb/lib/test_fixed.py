import numpy as np
import pytest
from amaranth.hdl import Cat, signed, unsigned

from golden.engine.lib.fixed import bit_length, limbs
from golden.engine.lib.fixed import round_shift as golden_round_shift
from hw.lib import fixed
from tb.lib.operator_bench import run_operator
from tb.lib.ranges import numbers

COUNT = 300
WIDTHS = [2, 3, 17, 18, 19, 36, 60]


def draw(shape, seed=1, **least):
    return numbers(np.random.default_rng(seed), shape, COUNT, **least)


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
    (came,), _ = run_operator([signed(width)], [signed(width + 1)],
                              lambda p, x: [p.combine(lambda x: fixed.round_shift(x, by), x)], [values])
    check(came, golden_round_shift(values, by))


@pytest.mark.parametrize("width", WIDTHS)
def test_magnitude_and_sign(width):
    values = draw(signed(width), least=1 - (1 << width - 1))

    def apply(p, x):
        size = p.combine(fixed.magnitude, x)
        assert len(size.value) == width - 1
        return [size, p.combine(lambda size, x: fixed.with_sign(size, x[-1]), size, x)]

    (size, back), _ = run_operator([signed(width)], [unsigned(width - 1), signed(width)], apply, [values])
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

    (high, low), _ = run_operator([signed(width)], [signed(width), signed(bits)], apply, [values])
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

    (moved, by), latency = run_operator([unsigned(width)], [unsigned(width), unsigned(steps)], apply, [values])
    expected = np.where(values == 0, (1 << steps) - 1, width - bit_length(values))
    check(by, expected)
    check(moved, np.where(values == 0, 0, values << np.where(values == 0, 0, expected)))
    assert latency == steps + 1


def test_normalise_together():
    width = 24
    a, b, c = (draw(unsigned(bits), seed) for seed, bits in enumerate((24, 20, 3)))

    def apply(p, *operands):
        moved, by = fixed.normalise(p, width, operands)
        return [*moved, by]

    (*moved, by), _ = run_operator([unsigned(24), unsigned(20), unsigned(3)], [unsigned(24)] * 3 + [unsigned(5)], apply,
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
    values = draw(shape(width))
    by = np.random.default_rng(3).integers(0, 64, len(values))
    (right, left), latency = run_operator(
        [shape(width), unsigned(steps)], [shape(width), unsigned(width)],
        lambda p, x, by: [fixed.shift_right(p, x, by, width), fixed.shift_left(p, x, by, width)], [values, by])
    check(right, values >> by)
    assert left == [int(value) << int(shift) & (1 << width) - 1 for value, shift in zip(values, by, strict=True)]
    assert latency == steps // fixed.LEVELS


@pytest.mark.parametrize(("factor", "interval"), [(1, 1), (107936, 1), (107936, 5), (107936, 17), (262143, 40)])
def test_serial_product(factor, interval):
    values = draw(signed(18))[::8]
    (came,), latency = run_operator([signed(18)], [signed(18 + factor.bit_length())],
                                    lambda p, a: [fixed.serial_product(p, a, factor)], [values], interval=interval)
    check(came, values * factor)
    assert latency == factor.bit_length() + 1


def test_small_product():
    a, b = np.meshgrid(np.arange(-8, 8), draw(signed(18)))
    (came,), latency = run_operator([signed(4), signed(18)], [signed(24)],
                                    lambda p, a, b: [fixed.small_product(p, a, b)],
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

    (came,), _ = run_operator([*map(signed, widths), unsigned(1)], [signed(max(widths) + 1)], apply, [a, b, chosen])
    check(came, np.where(chosen, a - b, a + b))


@pytest.mark.parametrize("count", [1, 2, 3, 5, 8])
def test_of_several(count):
    shapes = [signed(12 + k) for k in range(count)]
    columns = [draw(shape, seed) for seed, shape in enumerate(shapes)]
    (most, least, total), latency = run_operator(
        shapes, [signed(24)] * 3,
        lambda p, *x: [fixed.extreme(p, x, largest=True), fixed.extreme(p, x, largest=False), fixed.total(p, x)],
        columns)
    check(most, np.max(columns, axis=0))
    check(least, np.min(columns, axis=0))
    check(total, np.sum(columns, axis=0))
    assert latency == max(1, (count - 1).bit_length())
