"""Plane factor m = N/V: m . d is the inverse distance of the plane of a patch along a ray."""

from dataclasses import dataclass

import numpy as np

from golden.engine.config import Numbers
from golden.engine.icu.reciprocal import reciprocal
from golden.engine.lib.fixed import bit_length, limbs, round_shift

__all__ = ["PlaneFactor", "plane_factor"]

# A patch is dropped if its plane meets the cube of this many units around the origin.
NEAREST_PLANE = 2
# Guard bits of the operands of the product N x 1/V.
GUARD = 2
# Bits of the low limb of N in its product with a vertex.
LIMB = 25


@dataclass(frozen=True, eq=False)
class PlaneFactor:
    """Plane factors of P patches: m is ``mantissa 2^exponent`` per unit of the G cube's side.

    Parameters
    ----------
    mantissa
        P x 3 int64, the largest magnitude with exactly ``mantissa_bits`` bits; (0, 0, 0) if dropped.
    exponent
        P int64.
    dropped
        P bool: the plane passes through the origin within two units of the R frame, or there is no plane.
    """

    mantissa: np.ndarray
    exponent: np.ndarray
    dropped: np.ndarray

    def __getitem__(self, rows) -> "PlaneFactor":
        return PlaneFactor(self.mantissa[rows], self.exponent[rows], self.dropped[rows])


def plane_factor(vertices: np.ndarray, numbers: Numbers) -> PlaneFactor:
    """The factors of P patches from their vertices (P x 4 x 3 int64, R frame).

    N is the cross product of the diagonals and V = N . V_0, both exact. Division and product use their leading
    ``mantissa_bits`` + 2 bits, truncated; the result is rounded to ``mantissa_bits``. docs/exactness.md derives it.
    """
    bits = numbers.mantissa_bits + GUARD
    normal = np.cross(vertices[:, 2] - vertices[:, 0], vertices[:, 3] - vertices[:, 1])
    normal = numbers.plane_normal.check(normal, "plane normal")
    negative, high, low = _triple(normal, vertices[:, 0])

    # A V of more than 62 bits is far from the origin.
    small = high < 1 << (62 - LIMB)
    whole = np.where(small, (high << LIMB) | low, 0)
    dropped = small & (whole <= NEAREST_PLANE * np.abs(normal).sum(axis=1))

    length = np.where(small, bit_length(whole), bit_length(high) + LIMB)
    leading = np.where(small, _cut(whole, length - bits), _cut(high, length - LIMB - bits))
    inverse = reciprocal(np.where(dropped, 1 << (bits - 1), leading), bits)

    size = bit_length(np.abs(normal).max(axis=1))
    product = _cut(np.abs(normal), (size - bits)[:, None]) * inverse[:, None]
    lost = np.maximum(bit_length(product.max(axis=1)) - numbers.mantissa_bits, 0)
    mantissa = np.minimum(round_shift(product, lost[:, None]), (1 << numbers.mantissa_bits) - 1)
    mantissa = np.where((normal < 0) != negative[:, None], -mantissa, mantissa)
    # N is in units of 2^-2f and V in units of 2^-3f, f the fraction bits of a vertex.
    exponent = lost + (size - bits) - (2 * bits - 1) - (length - bits) + numbers.vector_fraction
    return PlaneFactor(np.where(dropped[:, None], 0, mantissa), np.where(dropped, 0, exponent), dropped)


def _cut(value: np.ndarray, by: np.ndarray) -> np.ndarray:
    """``value`` / 2^``by`` of values that are not negative, truncated; ``by`` < 0 multiplies."""
    return (value << np.maximum(-by, 0)) >> np.maximum(by, 0)


def _triple(normal, vertex):
    """N . V_0 as its sign and its magnitude ``high 2^LIMB + low`` with 0 <= low < 2^LIMB."""
    high, low = (np.einsum("pi,pi->p", limb, vertex) for limb in limbs(normal, LIMB))
    high, low = high + (low >> LIMB), low & ((1 << LIMB) - 1)
    negative = high < 0
    borrow = negative & (low > 0)
    return negative, np.where(negative, -high - borrow, high), np.where(borrow, (1 << LIMB) - low, low)
