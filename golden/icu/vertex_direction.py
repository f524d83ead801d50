"""Vertex direction: V' = V with 17-bit magnitudes, each vertex by its own leading zeros."""

import numpy as np

from golden.config import Numbers
from golden.fixed import bit_length, shift

__all__ = ["vertex_direction"]


def vertex_direction(vertices: np.ndarray, numbers: Numbers) -> tuple[np.ndarray, np.ndarray]:
    """``V' 2^exponent`` is V with the larger components rounded to ``vertex_bits`` bits.

    A magnitude that would round up to 2^vertex_bits becomes 2^vertex_bits - 1. Equal vertices give equal integers,
    which is what makes neighbours watertight.

    Parameters
    ----------
    vertices
        ... x 3 int64, R frame.

    Returns
    -------
    tuple
        ... x 3 V', and the ... exponents. The largest component has exactly ``vertex_bits`` bits but in the vertex
        (0, 0, 0), which stays.
    """
    exponent = bit_length(np.abs(vertices).max(axis=-1)) - numbers.vertex_bits
    limit = (1 << numbers.vertex_bits) - 1
    direction = np.clip(shift(vertices, -exponent[..., None]), -limit, limit)
    return numbers.vertex.check(direction, "vertex direction"), exponent
