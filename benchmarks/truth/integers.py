"""Arithmetic of Python's integers: rounding, leading bits, and vectors of three."""

__all__ = ["cross", "dot", "leading", "minus", "scaled", "sign", "to_nearest"]


def sign(value: int) -> int:
    """-1, 0 or 1."""
    return (value > 0) - (value < 0)


def to_nearest(value: int, shift: int) -> int:
    """``value`` / 2^``shift``, rounded to nearest and half away from zero."""
    if shift <= 0:
        return value << -shift
    return sign(value) * ((abs(value) + (1 << (shift - 1))) >> shift)


def leading(magnitude: int, bits: int, length: int) -> int:
    """The highest ``bits`` of ``length`` bits, truncated; of fewer ones all, with zeros below."""
    return magnitude >> (length - bits) if length >= bits else magnitude << (bits - length)


def minus(a, b) -> tuple:
    """The difference of two vectors."""
    return a[0] - b[0], a[1] - b[1], a[2] - b[2]


def scaled(vector, factor) -> tuple:
    """A vector times a number."""
    return vector[0] * factor, vector[1] * factor, vector[2] * factor


def cross(a, b) -> tuple:
    """The vector product."""
    return a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]


def dot(a, b):
    """The scalar product."""
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
