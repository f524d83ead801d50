"""CORDIC in vectoring mode: angles and lengths (circular), quotients (linear)."""

import numpy as np

from golden.engine.config import Icu
from golden.engine.lib.fixed import bit_length

__all__ = ["circular", "circular_error", "gain", "linear", "linear_error", "normalise", "rotations"]


def normalise(a: np.ndarray, b: np.ndarray, bits: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """A pair shifted left until the larger magnitude has ``bits`` bits, and the shift; (0, 0) stays."""
    by = bits - bit_length(np.maximum(np.abs(a), np.abs(b)))
    return a << by, b << by, by


def gain(icu: Icu) -> float:
    """Gain of `circular`: the factor by which it lengthens a vector."""
    return float(np.prod(np.sqrt(1 + 4.0 ** -np.arange(icu.cordic_stages))))


def circular(x: np.ndarray, y: np.ndarray, icu: Icu) -> tuple[np.ndarray, np.ndarray]:
    """Angle and length of (x, y).

    For x < 0 a half turn precedes. Stage i rotates by atan(2^-i) towards y = 0; a y of 0 counts as positive.

    Parameters
    ----------
    x, y
        int64, with ``cordic_guard`` fraction bits. `circular_error` states the least length of a pair.

    Returns
    -------
    tuple
        Angle from the x axis, unsigned, in units of 2^-``angle_bits`` turns; length times `gain`, in units of x and y.
    """
    half = 1 << (icu.angle_bits - 1)
    behind = x < 0
    x, y = (np.where(behind, -value, value) for value in (x, y))
    angle = np.where(behind, half, 0)
    for stage, rotation in enumerate(rotations(icu)):
        above = y >= 0
        step_x, step_y = y >> stage, x >> stage
        x, y = x + np.where(above, step_x, -step_x), y - np.where(above, step_y, -step_y)
        angle = angle + np.where(above, rotation, -rotation)
    return angle & (2 * half - 1), x


def circular_error(icu: Icu, bits: int) -> int:
    """Upper bound of the error of an angle, for pairs that are at least 2^(``bits`` - 1) long.

    It is the rest after the last stage, plus twice the rotation by truncating two numbers per stage (once where it
    occurs, once in the rest), plus half a unit for each entry of the table of angles (docs/exactness.md).
    """
    cut = icu.cordic_stages * np.sqrt(2) / 2.0 ** (bits - 1 + icu.cordic_guard)
    radians = np.arctan(2.0 ** (1 - icu.cordic_stages)) + 2 * cut
    return int(np.ceil(radians / (2 * np.pi) * 2.0**icu.angle_bits + icu.cordic_stages / 2))


def linear(y: np.ndarray, x: np.ndarray, icu: Icu) -> np.ndarray:
    """The quotient y / x in units of 2^-``cordic_stages``, for -x <= y <= x and x > 0.

    Stage i = 1, 2, ... adds or subtracts 2^-i. `linear_error` holds for x >= 2^16 (2^(vertex_bits - 1)).
    """
    x, y = x << icu.cordic_guard, y << icu.cordic_guard
    quotient = np.zeros_like(y)
    for stage in range(1, icu.cordic_stages + 1):
        above = y >= 0
        step, bit = x >> stage, 1 << (icu.cordic_stages - stage)
        y, quotient = y - np.where(above, step, -step), quotient + np.where(above, bit, -bit)
    return quotient


def linear_error(icu: Icu, bits: int) -> int:
    """Upper bound of the error of a quotient by x >= 2^(``bits`` - 1): the last stage's rest, and truncation."""
    cut = icu.cordic_stages * 2.0 ** (icu.cordic_stages - (bits - 1 + icu.cordic_guard))
    return int(np.ceil(1 + cut))


def rotations(icu: Icu) -> np.ndarray:
    """Rotation of each stage of `circular`: ``cordic_stages`` int, in units of 2^-``angle_bits`` turns."""
    return np.rint(np.arctan(2.0 ** -np.arange(icu.cordic_stages)) / (2 * np.pi) * 2.0**icu.angle_bits).astype(int)
