from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from golden.engine.config import Config
from golden.engine.icu.inverse_distance import SMALLEST, bound, decode, encode, inverse_distance
from golden.engine.icu.plane_factor import plane_factor
from golden.engine.icu.window import Window
from tb.golden.at_ends import at_ends
from tb.golden.engine.icu.patches import CONFIG, KINDS, hard_patches, hemisphere, meeting, screen, setup
from tb.lib.schedules import SETTINGS

NUMBERS = CONFIG.numbers


def stored(value, numbers, up):
    """The stored number of a fraction by the format's definition: truncated or rounded up within its range."""
    if value <= 0:
        return SMALLEST
    exponent = value.numerator.bit_length() - value.denominator.bit_length()
    exponent -= Fraction(2) ** exponent > value
    share = (value / Fraction(2) ** exponent - 1) * (1 << numbers.fraction_bits)
    key = (exponent + numbers.inverse_bias << numbers.fraction_bits) + (-(-share // 1) if up else share // 1)
    return min(max(int(key), SMALLEST), numbers.inverse.high)


@settings(SETTINGS, max_examples=100)
@given(st.lists(st.tuples(at_ends(-(1 << 20), (1 << 44) - 1), st.integers(-70, 50)), min_size=1, max_size=9),
       st.booleans(), st.sampled_from((18, 8)))
def test_stored_numbers_are_those_of_the_format_at_both_ends_of_its_range_too(pairs, up, fraction):
    numbers = Config().replace({"numbers.fraction_bits": fraction}).numbers
    assert numbers.inverse_bias == 39
    value, exponent = np.array(pairs).T
    expected = [stored(value * Fraction(2) ** exponent, numbers, up) for value, exponent in pairs]
    found = encode(value, exponent, numbers, up=up)
    assert found.tolist() == expected
    assert [stored(Fraction(one), numbers, up) for one in decode(found, numbers).tolist()] == expected
    assert decode(np.array(0), numbers) == 0


def test_the_largest_m_times_the_longest_direction_is_exact():
    longest, mantissa = 2**16, (1 << NUMBERS.mantissa_bits) - 1
    value = 3 * longest * mantissa
    assert value < 2**44
    stored = decode(encode(np.array([value]), np.array([-30]), NUMBERS), NUMBERS)[0] * 2.0**30
    assert value * (1 - 2.0**-18) < stored <= value
    assert (mantissa * (longest + 2) * 2) < 2**44  # a hemisphere's bound


@pytest.mark.parametrize("kind", KINDS)
def test_inverse_distances_are_those_of_the_plane(kind):
    record = hemisphere(64, 32)
    vertices = hard_patches(kind, 4, 100)
    directions = record.all_directions()
    patch, ray = meeting(setup(vertices)[1], directions)
    factor = plane_factor(vertices, NUMBERS)
    keep = ~factor.dropped[patch]
    patch, ray = patch[keep], ray[keep]
    stored = decode(inverse_distance(factor[patch], directions[ray], NUMBERS), NUMBERS)
    v = vertices[patch].astype(float) / 2**22
    normal = np.cross(v[:, 2] - v[:, 0], v[:, 3] - v[:, 1])
    m = normal / np.einsum("ki,ki->k", normal, v[:, 0])[:, None]
    exact = np.einsum("ki,ki->k", m, directions[ray]) / 2**16
    allowed = np.linalg.norm(m, axis=1) * 2.0**-21 + np.abs(exact) * 2.0**-18 + decode(SMALLEST, NUMBERS)
    assert (np.abs(stored - np.maximum(exact, 0)) <= allowed).all()


@pytest.mark.parametrize("record", [hemisphere(64, 16), screen(40, 30), screen(64, 64, 150.0)],
                         ids=["hemisphere", "screen", "wide screen"])
@pytest.mark.parametrize("kind", KINDS)
def test_no_ray_of_a_window_is_nearer_than_the_bound(record, kind):
    vertices = hard_patches(kind, 5, 60)
    factor = plane_factor(vertices, NUMBERS)
    live = np.flatnonzero(~factor.dropped)
    factor = factor[live]
    random = np.random.default_rng(6)
    first = random.integers(0, (record.columns, record.rows), (len(live), 2))
    count = np.minimum(random.integers(1, 12, (len(live), 2)), (record.columns, record.rows) - first)
    window = Window(first[:, 0], count[:, 0], first[:, 1], count[:, 1])
    patch, column, row = window.pairs(record.columns)
    inverse = inverse_distance(factor[patch], record.directions(column, row), NUMBERS)
    limit = bound(factor, window, record, CONFIG)
    assert (inverse <= limit[patch]).all()
    if record.is_screen:
        # The nearest corner is a ray: the bound is its inverse distance rounded down instead of up.
        nearest = np.zeros(len(live), dtype=np.int64)
        np.maximum.at(nearest, patch, inverse)
        assert (limit - nearest <= 1).all()
