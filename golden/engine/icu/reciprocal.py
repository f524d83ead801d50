"""Reciprocal: the only division, once per patch."""

import numpy as np

__all__ = ["reciprocal"]


def reciprocal(mantissa: np.ndarray, bits: int) -> np.ndarray:
    """``floor(2^(2 bits - 1) / mantissa)`` for mantissas of exactly ``bits`` bits: again ``bits`` bits.

    The reciprocal of 2^(bits - 1), the only one that would have another bit, is 2^bits - 1.
    """
    return np.minimum((1 << (2 * bits - 1)) // mantissa, (1 << bits) - 1)
