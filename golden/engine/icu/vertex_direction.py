"""Vertex direction: V' = V with 17-bit magnitudes, each vertex by its own leading zeros."""

import numpy as np

from golden.engine.config import Numbers
from golden.engine.lib.fixed import bit_length, shift

__all__ = ["vertex_direction"]


def vertex_direction(vertices: np.ndarray, numbers: Numbers) -> tuple[np.ndarray, np.ndarray]:
    """``V' 2^exponent`` is V with the larger components rounded to ``vertex_bits`` bits.

    A magnitude that would round up to 2^vertex_bits becomes 2^vertex_bits - 1. Equal vertices give equal integers,
    so neighbours are watertight (docs/exactness.md).

    Parameters
    ----------
    vertices
        ... x 3 int64, R frame.

    Returns
    -------
    tuple
        V', ... x 3 int64, and the exponents, ... int64. The largest component has exactly ``vertex_bits`` bits; the
        vertex (0, 0, 0) stays.
    """
    exponent = bit_length(np.abs(vertices).max(axis=-1)) - numbers.vertex_bits
    limit = (1 << numbers.vertex_bits) - 1
    direction = np.clip(shift(vertices, -exponent[..., None]), -limit, limit)
    return numbers.vertex.check(direction, "vertex direction"), exponent
