"""Bounds of inverse distances are at most as much above the nearest ray as their rounding, and never below it."""

from math import isqrt
from types import SimpleNamespace

import numpy as np
import pytest

from golden.engine.icu.inverse_distance import bound, decode, inverse_distance
from golden.engine.icu.plane_factor import PlaneFactor
from tb.golden.engine.icu.patches import CONFIG, hemisphere

ONE = 1 << 16
RECORD = SimpleNamespace(is_screen=False, longest_direction=ONE)


def factors(kind, count=40000):
    """Plane factors whose largest component has 24 bits; "leading": only the 12 bits that the bound reads."""
    random = np.random.default_rng(len(kind))
    mantissa = random.integers(-(1 << 24) + 1, 1 << 24, (count, 3))
    if kind == "flat":
        mantissa[:, 1:] >>= random.integers(0, 24, (count, 2))
    if kind == "axis":
        mantissa[:, 1:] = 0
    largest = np.abs(mantissa).max(axis=1)
    mantissa = mantissa[largest >= 1 << 23]
    return PlaneFactor(mantissa >> 12 << 12 if kind == "leading" else mantissa, np.zeros(len(mantissa), dtype=int) - 20,
                       np.zeros(len(mantissa), dtype=bool))


@pytest.mark.parametrize("kind", ["any", "flat", "axis", "leading"])
def test_a_ray_along_the_normal_is_within_the_bound_of_a_hemisphere(kind):
    factor = factors(kind)
    exact = factor.mantissa / np.linalg.norm(factor.mantissa, axis=1, keepdims=True) * ONE
    direction = np.trunc(exact).astype(np.int64)
    assert ((direction**2).sum(axis=1) <= ONE**2).all()
    nearest = inverse_distance(factor, direction, CONFIG.numbers)
    given = bound(factor, None, RECORD, CONFIG)
    assert (nearest <= given).all()
    # Twelve bits of each component and a whole root are above the length by less than 2^-11 each, the ray is cut to 16
    # bits and both distances to 18.
    share = decode(given, CONFIG.numbers) / decode(nearest, CONFIG.numbers)
    assert share.max() < 1 + 2.0**-10 + 2.0**-14
    # Some bounds are attained, so none of the roundings may be down.
    assert np.count_nonzero(given - nearest < 24) > (100 if kind in ("axis", "leading") else 0)


def test_the_bound_of_an_axis_is_its_leading_bits_rounded_up():
    mantissa = np.array([[(1 << 23) + more, 0, 0] for more in (0, 1, 32, 4095, 4096, 4097)])
    factor = PlaneFactor(mantissa, np.full(6, -20), np.zeros(6, dtype=bool))
    given = decode(bound(factor, None, RECORD, CONFIG), CONFIG.numbers) * 2.0**20
    assert given.tolist() == [(1 << 23) + more for more in (0, 4096, 4096, 4096, 4096, 8192)]


@pytest.mark.parametrize("rays", [(4, 4), (64, 16), (32, 512)])
def test_the_longest_direction_is_the_root_rounded_up(rays):
    record = hemisphere(*rays)
    longest = max(sum(part * part for part in one) for one in record.all_directions().tolist())
    assert record.longest_direction == isqrt(longest - 1) + 1
    assert ONE <= record.longest_direction <= ONE + 3
