import numpy as np
import pytest

from golden.engine.config import Icu
from golden.engine.lib.cordic import circular, circular_error, gain, linear, linear_error, normalise

SETTINGS = [Icu(), Icu(cordic_stages=8), Icu(cordic_stages=20, cordic_guard=8), Icu(cordic_guard=0, angle_bits=18)]


def pairs(bits, count=40000):
    """Pairs whose larger magnitude has ``bits`` bits, axes, diagonals and near misses of them included."""
    random = np.random.default_rng(bits)
    x, y = random.integers(-(2**bits) + 1, 2**bits, (2, count))
    top = 2**bits - 1
    edge = np.array([-top, -top + 1, -(2 ** (bits - 1)), -1, 0, 1, 2 ** (bits - 1), top - 1, top])
    x, y = np.concatenate([x, np.repeat(edge, 9)]), np.concatenate([y, np.tile(edge, 9)])
    long = np.maximum(np.abs(x), np.abs(y)) >= 2 ** (bits - 1)
    return x[long], y[long]


def worst_angle(icu, x, y):
    angle, _ = circular(x << icu.cordic_guard, y << icu.cordic_guard, icu)
    turn = 2**icu.angle_bits
    exact = np.arctan2(y, x) / (2 * np.pi) * turn
    return np.abs((angle - exact + turn / 2) % turn - turn / 2).max()


@pytest.mark.parametrize("bits", [10, 17])
@pytest.mark.parametrize("icu", SETTINGS, ids=str)
def test_angles_are_within_their_bound(icu, bits):
    x, y = pairs(bits)
    assert worst_angle(icu, x, y) <= circular_error(icu, bits)


@pytest.mark.parametrize("icu", SETTINGS, ids=str)
def test_lengths_are_gained_lengths(icu):
    x, y = pairs(17)
    _, length = circular(x << icu.cordic_guard, y << icu.cordic_guard, icu)
    exact = np.hypot(x, y) * gain(icu) * 2.0**icu.cordic_guard
    # Truncated once per stage, with a last angle of at most 2^(1 - stages).
    allowed = 2 * icu.cordic_stages + exact * 4.0 ** (1 - icu.cordic_stages)
    assert (np.abs(length - exact) <= allowed).all()


@pytest.mark.parametrize("bits", [10, 17])
@pytest.mark.parametrize("icu", SETTINGS, ids=str)
def test_quotients_are_within_their_bound(icu, bits):
    x, y = pairs(bits)
    x, y = np.maximum(np.abs(x), np.abs(y)), np.where(np.abs(x) < np.abs(y), x, y)
    error = np.abs(linear(y, x, icu) - y / x * 2.0**icu.cordic_stages).max()
    assert error <= linear_error(icu, bits)


def test_normalise_fills_the_bits_and_keeps_the_direction():
    x, y = np.array([1, -3, 0, 0, 70000]), np.array([0, 2, -1, 0, -5])
    a, b, by = normalise(x, y, 17)
    assert (a == x * 2**by).all()
    assert (b == y * 2**by).all()
    assert np.maximum(np.abs(a), np.abs(b)).tolist() == [65536, 98304, 65536, 0, 70000]
