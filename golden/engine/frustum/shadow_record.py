"""The record of a shadow frustum: rays from a point of a light to shaded points."""

from dataclasses import dataclass, replace

import numpy as np

from golden.engine.frustum.bundle import Bundle
from golden.engine.frustum.record import FrustumRecord, screen_slope_scale
from golden.engine.scene.g_coordinates import GCoordinates

__all__ = ["ShadowRecord", "shadow_record"]


@dataclass(frozen=True, kw_only=True, eq=False)
class ShadowRecord(FrustumRecord):
    """A screen whose rays are not its middles: each position of the grid has one ray at most.

    A ray has the direction of its position plus an offset, and an end. What it hits before its end blocks it. Rays that
    do not exist end at once, so that nothing blocks them.

    Parameters
    ----------
    offset
        R x 2 int64, units of 2^-16: x and y of each ray relative to the middle of its position, from -`spread` to
        `spread` - 1.
    end
        R int64: stored inverse distance of each ray's end. A hit counts if its own is larger.
    """

    offset: np.ndarray
    end: np.ndarray

    @property
    def bundle(self) -> Bundle:
        """See `FrustumRecord.bundle`."""
        return Bundle.SHADOW

    @property
    def spread(self) -> int:
        """Half the width of a position, see `FrustumRecord.spread`."""
        return 1 << self.numbers.direction_fraction - self.column_bits

    @property
    def listed(self) -> np.ndarray:
        """Numbers of the rays that something may block, int64 in ascending order: those of its list."""
        return np.flatnonzero(self.end < self.numbers.inverse.high)

    def parts(self, most: int) -> list["ShadowRecord"]:
        """Frusta of the same grid that have its `listed` rays together, at most so many each, in their order."""
        listed, parts = self.listed, []
        if 0 < len(listed) <= most:
            return [self]
        for first in range(0, len(listed), most):
            own = listed[first:first + most]
            end = np.full_like(self.end, self.numbers.inverse.high)
            end[own] = self.end[own]
            parts.append(replace(self, end=end))
        return parts

    def directions(self, column, row) -> np.ndarray:
        """See `FrustumRecord.directions`."""
        directions = super().directions(column, row)
        directions[..., :2] += self.offset[row * self.columns + column]
        return directions

    def corner_directions(self, columns: np.ndarray, rows: np.ndarray) -> np.ndarray:
        """See `FrustumRecord.corner_directions`."""
        directions = super().directions(columns[:, :, None], rows[:, None, :])
        directions[:, 0, :, 0] -= self.spread
        directions[:, 1, :, 0] += self.spread
        directions[:, :, 0, 1] -= self.spread
        directions[:, :, 1, 1] += self.spread
        return directions


def shadow_record(coordinates: GCoordinates, origin: np.ndarray, axes: np.ndarray, bits: int, *, slopes: np.ndarray,
                  end: np.ndarray, source: int = -1) -> tuple[ShadowRecord, np.ndarray]:
    """The frustum of K rays, no two of which have the same `position`.

    Parameters
    ----------
    coordinates
        The coordinates of the scene.
    origin
        3 int64, G coordinates of the point of the light.
    axes
        3 x 3 rotation: its rows are the R axes, the last one the viewing direction.
    bits
        Binary logarithm of the grid's columns and of its rows, which span slopes from -1 to 1.
    slopes
        K x 2 int64, units of 2^-16, from -2^16 to 2^16 - 1.
    end
        K int64, see `ShadowRecord`.
    source
        The surface of the point of the light, or -1.

    Returns
    -------
    The frustum, and the number of each ray in it.
    """
    numbers = coordinates.numbers
    encode, side = numbers.direction.encode, 1 << bits
    number = position(slopes, bits, numbers)
    middles = ((2 * np.arange(side) + 1 - side) << numbers.direction_fraction - bits)[:, None]
    offset = np.zeros((side * side, 2), dtype=np.int64)
    offset[number] = slopes - middles[np.stack([number % side, number // side], axis=1), 0]
    ends = np.full(side * side, numbers.inverse.high)
    ends[number] = end
    return ShadowRecord(
        is_screen=True, numbers=numbers, origin=origin, matrix=encode(axes, "frustum matrix"),
        to_global=encode(axes.T / [1, 1, screen_slope_scale((1.0, 1.0))], "frustum matrix"),
        z_scale=1 << numbers.direction_fraction, half_angles=(1.0, 1.0), columns=side, rows=side, column_bits=bits,
        row_bits=bits, column_table=middles, row_table=middles, source=source, offset=offset, end=ends), number


def position(slopes: np.ndarray, bits: int, numbers) -> np.ndarray:
    """The number of the position that holds each ray: row times columns plus column; see `shadow_record`."""
    column, row = (slopes + (1 << numbers.direction_fraction) >> numbers.direction_fraction + 1 - bits).T
    return (row << bits) + column
