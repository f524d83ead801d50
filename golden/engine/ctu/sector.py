"""Sectors and subshells: the grid rays of a shell that belong to a part of the frustum."""

from dataclasses import dataclass

import numpy as np

from golden.engine.ctu.grid_rays import INDEX_FRACTION, GridRays
from golden.engine.frustum import FrustumRecord

__all__ = ["Sector", "sector_rays", "subshell_rays"]


@dataclass(frozen=True)
class Sector:
    """A part of a frustum: the intersection rays with ``first_column <= column < end_column`` and likewise rows."""

    first_column: int
    end_column: int
    first_row: int
    end_row: int

    @classmethod
    def whole(cls, record: FrustumRecord) -> "Sector":
        """All rays of a frustum."""
        return cls(0, record.columns, 0, record.rows)

    @classmethod
    def around(cls, rays: np.ndarray, record: FrustumRecord) -> "Sector":
        """The smallest one with some rays of a frustum, by their numbers."""
        row, column = np.divmod(rays, record.columns)
        return cls(int(column.min()), int(column.max()) + 1, int(row.min()), int(row.max()) + 1)

    @property
    def rays(self) -> int:
        """Its number of rays."""
        return (self.end_column - self.first_column) * (self.end_row - self.first_row)

    def mask(self, record: FrustumRecord) -> np.ndarray:
        """Whether each ray of a frustum is in the sector: rows x columns bool."""
        mask = np.zeros((record.rows, record.columns), dtype=bool)
        mask[self.first_row:self.end_row, self.first_column:self.end_column] = True
        return mask

    def among(self, rays: np.ndarray, record: FrustumRecord) -> np.ndarray:
        """Those of some rays of a frustum, by their numbers, that are in the sector; in their order."""
        return rays[self.mask(record).ravel()[rays]]


def sector_rays(rays: GridRays, sector: Sector, record: FrustumRecord) -> np.ndarray:
    """Which grid rays can open a cell that holds a hit of the sector's intersection rays: rows x columns bool.

    They are in the sector or within `GridRays.row_border` and `GridRays.column_border` of it, also beyond the border
    of the frustum, such as below the horizon.
    """
    rows = (rays.row_position >= (sector.first_row << INDEX_FRACTION) - rays.row_border) \
        & (rays.row_position <= (sector.end_row << INDEX_FRACTION) + rays.row_border)
    first = (sector.first_column << INDEX_FRACTION) - rays.column_border[:, None]
    length = (sector.end_column - sector.first_column << INDEX_FRACTION) + 2 * rays.column_border[:, None]
    return rows[:, None] & (_offset(rays.column_position - first, record) <= length)


def subshell_rays(rays: GridRays, window, record: FrustumRecord) -> np.ndarray:
    """Which grid rays pass through a window of intersection rays: rows x columns bool.

    Parameters
    ----------
    window
        First column, columns, first row, rows; in a hemisphere columns wrap around the circle.
    """
    first_column, columns, first_row, rows = (int(value) << INDEX_FRACTION for value in window)
    inside = (rays.row_position >= first_row) & (rays.row_position < first_row + rows)
    return inside[:, None] & (_offset(rays.column_position - first_column, record) < columns)[None]


def _offset(columns, record):
    """Offsets of columns from a first one: modulo the circle, or (screen) larger than any length if negative."""
    if record.is_screen:
        return np.where(columns < 0, np.iinfo(np.int64).max, columns)
    return columns % (record.columns << INDEX_FRACTION)
