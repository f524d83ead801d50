"""Fixed-point numbers as int64 arrays: formats, rounding, and the check that nothing overflows."""

from dataclasses import dataclass

import numpy as np

__all__ = ["Format", "SignalOverflowError", "bit_length", "ceil_sqrt", "limbs", "round_shift", "shift", "signed",
           "unsigned"]


class SignalOverflowError(ArithmeticError):
    """A signal does not fit its format: the model is wrong, or its input is out of range."""


@dataclass(frozen=True)
class Format:
    """A fixed-point format: ``integer`` bits before the point, ``fraction`` bits after it, and a sign or none.

    *Signed a.b* has 1 + a + b bits, *unsigned a.b* a + b.
    """

    is_signed: bool
    integer: int
    fraction: int

    @property
    def width(self) -> int:
        """Bits of the format."""
        return self.is_signed + self.integer + self.fraction

    @property
    def low(self) -> int:
        """The smallest integer that fits."""
        return -(1 << (self.width - 1)) if self.is_signed else 0

    @property
    def high(self) -> int:
        """The largest integer that fits."""
        return (1 << (self.width - self.is_signed)) - 1

    def check(self, value: np.ndarray, signal: str) -> np.ndarray:
        """``value``, after a check that it fits.

        Raises
        ------
        SignalOverflowError
            One of the integers does not fit; the message names ``signal``.
        """
        value = np.asarray(value)
        if value.size and (value.min() < self.low or value.max() > self.high):
            worst = int(value.max() if value.max() > self.high else value.min())
            raise SignalOverflowError(f"{signal} must fit {self}, not be {worst}")
        return value

    def encode(self, real, signal: str) -> np.ndarray:
        """The nearest integers to ``real`` x 2^``fraction``, half away from zero, checked."""
        scaled = np.asarray(real, dtype=np.float64) * 2.0**self.fraction
        return self.check((np.sign(scaled) * np.floor(np.abs(scaled) + 0.5)).astype(np.int64), signal)

    def decode(self, value) -> np.ndarray:
        """The real numbers that the integers ``value`` represent: float64."""
        return np.asarray(value) * 2.0**-self.fraction

    def __str__(self) -> str:
        return f"{'signed' if self.is_signed else 'unsigned'} {self.integer}.{self.fraction}"


def signed(integer: int, fraction: int) -> Format:
    """The format *signed a.b*."""
    return Format(True, integer, fraction)


def unsigned(integer: int, fraction: int) -> Format:
    """The format *unsigned a.b*."""
    return Format(False, integer, fraction)


def round_shift(value: np.ndarray, by) -> np.ndarray:
    """``value`` / 2^``by``, to the nearest integer, half away from zero: -x gives the negative of the result of x.

    ``by`` is at least 0 and may be an array; below 2^62 in magnitude.
    """
    by = np.asarray(by)
    magnitude = (np.abs(value) + ((1 << by) >> 1)) >> by
    return np.where(value < 0, -magnitude, magnitude)


def shift(value: np.ndarray, by) -> np.ndarray:
    """``value`` x 2^``by``: exact for ``by`` >= 0, else rounded by `round_shift`."""
    by = np.asarray(by)
    return round_shift(value << np.maximum(by, 0), np.maximum(-by, 0))


def bit_length(value: np.ndarray) -> np.ndarray:
    """Bits of each integer from 0 to 2^63 - 1: the position of its leading one plus one; 0 for 0."""
    value = np.asarray(value, dtype=np.int64)
    high = value >> 32
    part = np.where(high > 0, high, value)
    return np.frexp(part.astype(np.float64))[1].astype(np.int64) + np.where(high > 0, 32, 0)


def limbs(value: np.ndarray, bits: int) -> tuple[np.ndarray, np.ndarray]:
    """(h, l) with ``value = h 2^bits + l`` and ``-2^(bits-1) <= l < 2^(bits-1)``: two balanced limbs."""
    half = 1 << (bits - 1)
    high = (value + half) >> bits
    return high, value - (high << bits)


def ceil_sqrt(value: np.ndarray) -> np.ndarray:
    """The smallest integers whose squares are at least ``value``, for 0 <= ``value`` < 2^52."""
    root = np.ceil(np.sqrt(value.astype(np.float64))).astype(np.int64)
    root -= (root - 1) * (root - 1) >= value
    root += root * root < value
    return np.maximum(root, 0)
