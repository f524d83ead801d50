"""Directions of the rays of hemispheres and screens, in units of 2^-16, from the formulas of docs/fixed-point.md."""

import math

import numpy as np

from benchmarks.truth.integers import to_nearest

__all__ = ["hemisphere_directions", "screen_directions"]


def hemisphere_directions(azimuths: int, polars: int) -> np.ndarray:
    """(sin p cos a, sin p sin a, cos p), polars x azimuths x 3; tables and products rounded."""
    rows = [_rounded((2 * row + 1) * math.pi / (4 * polars)) for row in range(polars)]
    columns = [_rounded((2 * column + 1) * math.pi / azimuths) for column in range(azimuths)]
    return np.array([[(to_nearest(sine * x, 16), to_nearest(sine * y, 16), cosine) for x, y in columns]
                     for cosine, sine in rows])


def screen_directions(width: int, height: int, pitch: float) -> np.ndarray:
    """(x, y, 1), height x width x 3: x and y of the middles of pixels, whose side is the slope ``pitch``, in a grid of
    powers of two from -1 to 1.
    """
    least = min((max(width, height) - 1).bit_length() - 1, math.ceil(-math.log2(pitch)))
    x, y = ([(2 * number + 1 - size) << 16 >> max(1, (size - 1).bit_length(), least) for number in range(size)]
            for size in (width, height))
    return np.array([[(column, row, 1 << 16) for column in x] for row in y])


def _rounded(angle):
    """Cosine and sine: float64 is 2^-53 off, and no angle of a grid is nearer to the middle of two integers."""
    return [int(math.copysign(math.floor(abs(value) * 2**16 + 0.5), value))
            for value in (math.cos(angle), math.sin(angle))]
