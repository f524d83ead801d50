from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from golden.engine.lib.fixed import (
    SignalOverflowError,
    bit_length,
    ceil_sqrt,
    limbs,
    round_shift,
    shift,
    signed,
    unsigned,
)
from tb.golden.at_ends import at_ends
from tb.lib.schedules import SETTINGS


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


def rounded(value):
    """The nearest integer to a fraction, half away from zero."""
    return int(abs(value) + Fraction(1, 2)) * (1 if value >= 0 else -1)


@st.composite
def shifted(draw):
    """Numbers up to 2^61 with a shift, of which whole and half results and their neighbours are frequent."""
    by = draw(st.integers(0, 61))
    most = 1 << 61 - by
    whole, half = draw(at_ends(-most, most - 1)), draw(st.booleans())
    return (whole << by) + half * (1 << by >> 1) + draw(st.integers(-1, 1)), by


@settings(SETTINGS, max_examples=100)
@given(st.lists(shifted(), min_size=1, max_size=9))
def test_round_shift_is_to_nearest_and_half_away_from_zero(pairs):
    values, by = np.array(pairs).T
    assert round_shift(values, by).tolist() == [rounded(Fraction(value, 1 << step)) for value, step in pairs]


@settings(SETTINGS, max_examples=100)
@given(st.lists(st.tuples(at_ends(-(2**31), 2**31), st.integers(-40, 30)), min_size=1, max_size=9))
def test_shift_goes_both_ways_per_element(pairs):
    values, by = np.array(pairs).T
    assert shift(values, by).tolist() == [rounded(value * Fraction(2) ** step) for value, step in pairs]


@settings(SETTINGS, max_examples=60)
@given(is_signed=st.booleans(), integer=st.integers(0, 8), fraction=st.integers(1, 20), step=st.integers(-9, 9))
def test_encode_takes_what_rounds_to_an_end_of_its_format_and_no_more(is_signed, integer, fraction, step):
    number = (signed if is_signed else unsigned)(integer, fraction)
    for end, outwards in ((number.low, -1), (number.high, 1)):
        # In eighths of a unit: half a unit outwards rounds away from zero.
        units = end + outwards * Fraction(step, 8)
        nearest = rounded(units)
        if number.low <= nearest <= number.high:
            assert number.encode(float(units) / 2**fraction, "x") == nearest
        else:
            with pytest.raises(SignalOverflowError):
                number.encode(float(units) / 2**fraction, "x")


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
