"""Inverse distance: 1/t as an unsigned float that compares as an integer; larger is nearer, 0 is no hit."""

import numpy as np

from golden.config import Config, Numbers
from golden.fixed import bit_length, ceil_sqrt
from golden.frustum import FrustumRecord
from golden.icu.plane_factor import PlaneFactor
from golden.icu.window import Window

__all__ = ["SMALLEST", "bound", "decode", "encode", "inverse_distance"]

# What a hit has whose inverse distance rounds to nothing.
SMALLEST = 1
# Bits that the bound of a hemisphere takes of each component of m.
BOUND_BITS = 12


def encode(value: np.ndarray, exponent: np.ndarray, numbers: Numbers, *, up: bool = False) -> np.ndarray:
    """``value 2^exponent`` in the stored format.

    Cut off, or rounded ``up``; `SMALLEST` for what is not positive or too small, the largest number for what is too
    large.

    Parameters
    ----------
    value
        int64 below 2^44 in magnitude.
    """
    fraction = numbers.fraction_bits
    length = bit_length(np.maximum(value, 1)) - 1
    # The leading one stands at the exponent's lowest bit, so that one addition makes 1.f 2^e of both.
    down = np.maximum(length - fraction, 0)
    leading = (np.maximum(value, 1) >> down) << np.maximum(fraction - length, 0)
    if up:
        leading = leading + ((leading >> np.maximum(fraction - length, 0) << down) != np.maximum(value, 1))
    place = length + exponent + numbers.inverse_bias
    key = (place << fraction) + leading - (1 << fraction)
    return np.where(value > 0, np.clip(key, SMALLEST, numbers.inverse.high), SMALLEST)


def decode(key: np.ndarray, numbers: Numbers) -> np.ndarray:
    """The real number that a stored inverse distance stands for: float64, 0 for no hit."""
    key = np.asarray(key)
    fraction = numbers.fraction_bits
    leading = (key & ((1 << fraction) - 1)) + (1 << fraction)
    return np.where(key > 0, np.ldexp(leading.astype(np.float64),
                                      (key >> fraction) - numbers.inverse_bias - fraction), 0.0)


def inverse_distance(factor: PlaneFactor, directions: np.ndarray, numbers: Numbers) -> np.ndarray:
    """1/t at which ray k meets the plane of patch k, stored.

    Parameters
    ----------
    factor
        Of K patches, none of them dropped.
    directions
        K x 3 int64.
    """
    value = np.einsum("ki,ki->k", factor.mantissa, directions)
    return encode(value, factor.exponent - numbers.direction_fraction, numbers)


def bound(factor: PlaneFactor, window: Window, record: FrustumRecord, config: Config) -> np.ndarray:
    """An upper bound of the inverse distances of a patch to the rays of its window, stored.

    A ray that is strictly nearer need not be tested. Hemisphere: an upper bound of the length of m, from the leading
    12 bits of its components, times the longest direction. Screen: the largest m . d of the window's four corners.
    """
    numbers = config.numbers
    if record.is_screen:
        column = np.stack([window.column_first, window.column_first + np.maximum(window.column_count, 1) - 1], axis=1)
        row = np.stack([window.row_first, window.row_first + np.maximum(window.row_count, 1) - 1], axis=1)
        corners = record.directions(column[:, :, None], row[:, None, :])
        value = np.einsum("pi,pcri->pcr", factor.mantissa, corners).max(axis=(1, 2))
    else:
        lost = numbers.mantissa_bits - BOUND_BITS
        leading = -(-np.abs(factor.mantissa) >> lost)
        value = (ceil_sqrt((leading * leading).sum(axis=1)) << lost) * record.longest_direction
    return encode(value, factor.exponent - numbers.direction_fraction, numbers, up=True)
