"""Virtual frusta: equal blocks of a frustum's rays, each represented by one ray that is cast."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from golden.base.errors import InputError, check_int
from golden.engine.icu.window import Window
from golden.engine.schedule.sections import grid_of

__all__ = ["Overlaps", "VirtualFrusta", "most_ratio"]


@dataclass(frozen=True, eq=False)
class Overlaps:
    """Overlaps of windows and virtual frusta.

    Parameters
    ----------
    window, column, row
        K int64: number of the window, column and row of the frustum.
    rays
        K int64: rays of the window in the frustum, at least 1.
    covers
        K bool: the window holds all rays of the frustum.
    """

    window: np.ndarray
    column: np.ndarray
    row: np.ndarray
    rays: np.ndarray
    covers: np.ndarray


@dataclass(frozen=True)
class VirtualFrusta:
    """Blocks of ``width`` x ``height`` of ``columns`` x ``rows`` rays; the border may cut the last blocks.

    The ray at or after the middle of a block is cast.
    """

    columns: int
    rows: int
    width: int
    height: int

    @classmethod
    def of(cls, columns: int, rows: int, ratio: int) -> "VirtualFrusta":
        """Blocks of ``ratio`` rays, as square as possible, not higher than wide.

        Raises
        ------
        InputError
            The ratio is no power of two, or a block is wider or higher than the frustum.
        TypeError
            The ratio is no int.
        """
        check_int("schedule: Ratio", ratio)
        if ratio < 1 or ratio & (ratio - 1):
            raise InputError(f"schedule: Ratio must be a power of two, not {ratio!r}", parameter="ratio")
        if ratio > most_ratio(columns, rows):
            raise InputError(f"schedule: Ratio must leave a ray of {columns} x {rows}, not be {ratio!r}",
                             parameter="ratio")
        return cls(columns, rows, *grid_of(ratio))

    @property
    def shape(self) -> tuple[int, int]:
        """Rows V and columns U of frusta."""
        return -(-self.rows // self.height), -(-self.columns // self.width)

    @cached_property
    def rays(self) -> tuple[np.ndarray, np.ndarray]:
        """Column and row of the ray cast for each frustum: V x U int64 each."""
        row, column = np.indices(self.shape)
        return (np.minimum(column * self.width + self.width // 2, self.columns - 1),
                np.minimum(row * self.height + self.height // 2, self.rows - 1))

    @cached_property
    def sizes(self) -> np.ndarray:
        """V x U int64: rays of each frustum."""
        down, across = (np.minimum(size, total - np.arange(0, total, size))
                        for size, total in ((self.height, self.rows), (self.width, self.columns)))
        return down[:, None] * across

    def spread(self, values: np.ndarray) -> np.ndarray:
        """The value of each ray's frustum: rows x columns."""
        return values.repeat(self.height, axis=0).repeat(self.width, axis=1)[:self.rows, :self.columns]

    def share(self, values: np.ndarray) -> np.ndarray:
        """Each ray's share of the value of its frustum: rows x columns float64."""
        return self.spread(values / self.sizes)

    def overlaps(self, window: Window) -> Overlaps:
        """Overlaps of all windows; a frustum that a wrapped window enters at both ends occurs twice."""
        column_end, row_end = window.column_first + window.column_count, window.row_first + window.row_count
        # A window that wraps is one part up to the last column and one from the first.
        over = np.flatnonzero(column_end > self.columns)
        number = np.concatenate([np.arange(len(row_end)), over])
        left = np.concatenate([window.column_first, np.zeros_like(over)])
        right = np.concatenate([np.minimum(column_end, self.columns), column_end[over] - self.columns])
        top, bottom = window.row_first[number], row_end[number]
        blocks = Window(left // self.width, -(-right // self.width) - left // self.width,
                        top // self.height, -(-bottom // self.height) - top // self.height)
        empty = (right <= left) | (bottom <= top)
        which, column, row = blocks.only(~empty).pairs(self.shape[1])
        first, end = np.maximum(left[which], column * self.width), np.minimum(right[which], (column + 1) * self.width)
        above, below = np.maximum(top[which], row * self.height), np.minimum(bottom[which], (row + 1) * self.height)
        rays = (end - first) * (below - above)
        return Overlaps(number[which], column, row, rays, rays == self.sizes[row, column])


def most_ratio(columns: int, rows: int) -> int:
    """The largest ratio whose blocks are neither wider nor higher than so many rays."""
    return 1 << min(2 * (columns.bit_length() - 1), 2 * rows.bit_length() - 1)
