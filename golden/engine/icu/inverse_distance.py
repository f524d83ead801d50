"""Inverse distance: 1/t as an unsigned float that compares as an integer; larger is nearer, 0 means no hit."""

import numpy as np

from golden.engine.config import Config, Numbers
from golden.engine.frustum import FrustumRecord
from golden.engine.icu.plane_factor import PlaneFactor
from golden.engine.icu.window import Window
from golden.engine.lib.fixed import bit_length, ceil_sqrt

__all__ = ["SMALLEST", "bound", "decode", "encode", "inverse_distance"]

# Stored inverse distance of a hit whose 1/t is not positive after rounding.
SMALLEST = 1
# Leading bits of each component of m in the bound of a hemisphere.
BOUND_BITS = 12


def encode(value: np.ndarray, exponent: np.ndarray, numbers: Numbers, *, up: bool = False) -> np.ndarray:
    """``value 2^exponent`` in the stored format.

    Truncated, or rounded ``up``. A value that is not positive or too small gives `SMALLEST`, too large a value the
    largest number.

    Parameters
    ----------
    value
        int64 below 2^44 in magnitude.
    exponent
        int64, broadcasts with ``value``.
    """
    fraction = numbers.fraction_bits
    length = bit_length(np.maximum(value, 1)) - 1
    # The leading one has the weight of the exponent's lowest bit, so one addition combines exponent and fraction.
    down = np.maximum(length - fraction, 0)
    leading = (np.maximum(value, 1) >> down) << np.maximum(fraction - length, 0)
    if up:
        leading = leading + ((leading >> np.maximum(fraction - length, 0) << down) != np.maximum(value, 1))
    biased = length + exponent + numbers.inverse_bias
    key = (biased << fraction) + leading - (1 << fraction)
    return np.where(value > 0, np.clip(key, SMALLEST, numbers.inverse.high), SMALLEST)


def decode(key: np.ndarray, numbers: Numbers) -> np.ndarray:
    """The value of a stored inverse distance: float64, 0 for no hit."""
    key = np.asarray(key)
    fraction = numbers.fraction_bits
    leading = (key & ((1 << fraction) - 1)) + (1 << fraction)
    return np.where(key > 0, np.ldexp(leading.astype(np.float64),
                                      (key >> fraction) - numbers.inverse_bias - fraction), 0.0)


def inverse_distance(factor: PlaneFactor, directions: np.ndarray, numbers: Numbers) -> np.ndarray:
    """Stored 1/t at which ray k meets the plane of patch k.

    Parameters
    ----------
    factor
        Plane factors of K patches, none of them dropped.
    directions
        K x 3 int64.

    Returns
    -------
    K int64.
    """
    value = np.einsum("ki,ki->k", factor.mantissa, directions)
    return encode(value, factor.exponent - numbers.direction_fraction, numbers)


def bound(factor: PlaneFactor, window: Window, record: FrustumRecord, config: Config) -> np.ndarray:
    """Stored upper bound of the inverse distances of each patch for the rays of its window: P int64.

    A ray with a strictly larger one need not be tested. Hemisphere: an upper bound of the length of m, from the leading
    12 bits of its components, times the longest direction. Screen: the largest m . d of the window's four corners.
    """
    numbers = config.numbers
    if record.is_screen:
        column = np.stack([window.column_first, window.column_first + np.maximum(window.column_count, 1) - 1], axis=1)
        row = np.stack([window.row_first, window.row_first + np.maximum(window.row_count, 1) - 1], axis=1)
        corners = record.corner_directions(column, row)
        value = np.einsum("pi,pcri->pcr", factor.mantissa, corners).max(axis=(1, 2))
    else:
        lost = numbers.mantissa_bits - BOUND_BITS
        leading = -(-np.abs(factor.mantissa) >> lost)
        value = (ceil_sqrt((leading * leading).sum(axis=1)) << lost) * record.longest_direction
    return encode(value, factor.exponent - numbers.direction_fraction, numbers, up=True)
