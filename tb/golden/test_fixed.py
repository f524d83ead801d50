import numpy as np
import pytest

from golden.fixed import SignalOverflowError, bit_length, ceil_sqrt, limbs, round_shift, shift, signed, unsigned


def test_formats_have_the_widths_and_limits_of_their_names():
    assert (signed(1, 16).width, signed(1, 16).low, signed(1, 16).high) == (18, -(2**17), 2**17 - 1)
    assert (unsigned(0, 24).width, unsigned(0, 24).low, unsigned(0, 24).high) == (24, 0, 2**24 - 1)
    assert str(signed(1, 22)) == "signed 1.22"


@pytest.mark.parametrize(("number", "bad"), [(signed(1, 2), 8), (signed(1, 2), -9), (unsigned(2, 1), 8),
                                             (unsigned(2, 1), -1)])
def test_an_overflow_names_the_signal_and_never_wraps(number, bad):
    fits = np.array([number.low, 0, number.high])
    assert number.check(fits, "edge plane") is fits
    with pytest.raises(SignalOverflowError, match=rf"^edge plane must fit {number}, not be {bad}$"):
        number.check(np.array([0, bad]), "edge plane")


def test_encode_rounds_half_away_from_zero():
    assert signed(3, 1).encode([0.25, -0.25, 0.74, -0.76, 1.0], "x").tolist() == [1, -1, 1, -2, 2]
    assert signed(3, 1).decode(np.array([3, -1])).tolist() == [1.5, -0.5]


def test_round_shift_is_symmetric_and_to_nearest():
    values = np.arange(-40, 41)
    for by in range(4):
        exact = np.abs(values) / 2**by
        expected = np.where(values < 0, -1, 1) * np.floor(exact + 0.5)
        assert (round_shift(values, by) == expected).all()
    assert (round_shift(-values, np.full(81, 3)) == -round_shift(values, 3)).all()
    assert round_shift(np.array([2**61]), 61).tolist() == [1]


def test_shift_goes_both_ways_per_element():
    assert shift(np.array([3, -3, 7]), np.array([2, -1, 0])).tolist() == [12, -2, 7]


def test_bit_length_is_pythons():
    edges = [value for k in range(63) for value in (2**k - 1, 2**k, 2**k + 1)]
    values = edges + np.random.default_rng(1).integers(0, 2**63 - 1, 2000).tolist()
    assert bit_length(np.array(values)).tolist() == [value.bit_length() for value in values]


@pytest.mark.parametrize("bits", [18, 25])
def test_limbs_are_balanced_and_whole(bits):
    values = np.random.default_rng(2).integers(-(2**60), 2**60, 5000)
    values[:4] = [0, 2 ** (bits - 1), -(2 ** (bits - 1)), 2 ** (bits - 1) - 1]
    high, low = limbs(values, bits)
    assert (high * 2**bits + low == values).all()
    assert low.min() >= -(2 ** (bits - 1))
    assert low.max() < 2 ** (bits - 1)


def test_ceil_sqrt_is_exact_around_squares():
    roots = np.concatenate([np.arange(200), np.random.default_rng(3).integers(1, 2**26, 2000)])
    assert (ceil_sqrt(roots**2) == roots).all()
    assert (ceil_sqrt(roots**2 + 1) == roots + 1).all()
