"""Subshell grid: the subshells of one shell of a sector, all of the same extents."""

from dataclasses import dataclass

import numpy as np

from golden.engine.ctu.grid_rays import INDEX_FRACTION, GridRays
from golden.engine.ctu.sector import Sector

__all__ = ["SubshellGrid"]


@dataclass(frozen=True, kw_only=True)
class SubshellGrid:
    """A sector cut into windows of ``extents``, row by row; the last ones are smaller.

    Parameters
    ----------
    sector
        The sector.
    columns
        Columns of the hemisphere, around which rays wrap.
    extents
        Columns and rows of a subshell, at least 1.
    """

    sector: Sector
    columns: int
    extents: tuple[int, int]

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of subshells."""
        sector, (across, down) = self.sector, self.extents
        return -(-(sector.end_row - sector.first_row) // down), -(-(sector.end_column - sector.first_column) // across)

    def __len__(self) -> int:
        rows, columns = self.shape
        return rows * columns

    @property
    def windows(self) -> tuple[np.ndarray, ...]:
        """First column, columns, first row and rows of each subshell, in rays of the frustum."""
        row, column = np.divmod(np.arange(len(self)), self.shape[1])
        (across, down), sector = self.extents, self.sector
        column, row = sector.first_column + column * across, sector.first_row + row * down
        return (column, np.minimum(across, sector.end_column - column), row, np.minimum(down, sector.end_row - row))

    def numbers(self, column: np.ndarray, row: np.ndarray) -> np.ndarray:
        """The subshells of rays; a ray outside the sector belongs to the one nearest to it."""
        column, row = self._inside(column, row)
        return row // self.extents[1] * self.shape[1] + column // self.extents[0]

    def of_grid_rays(self, rays: GridRays) -> np.ndarray:
        """The subshell of each grid ray of the shell: rows x columns int64."""
        return self.numbers(rays.column_position[None] >> INDEX_FRACTION, rays.row_position[:, None] >> INDEX_FRACTION)

    def ranges(self, column, columns, row, rows) -> tuple[np.ndarray, ...]:
        """Of windows of rays the first and last rows, then columns of the subshells that they meet.

        A window that meets no ray of the sector belongs to the subshell nearest to it; of one that wraps in the sector
        the columns are all.
        """
        sector, (across, down) = self.sector, self.extents
        width, height = sector.end_column - sector.first_column, sector.end_row - sector.first_row
        first = (np.asarray(column) - sector.first_column) % self.columns
        end = first + columns
        last = np.where(first < width, end, np.maximum(end - self.columns, 1)) - 1
        is_all = (columns >= self.columns) | (first < width) & (end > self.columns)
        first, last = np.where(is_all | (first >= width), 0, first), np.where(is_all, width - 1, last)
        top = np.asarray(row) - sector.first_row
        bottom = top + rows - 1
        first, last = (np.clip(value, 0, width - 1) // across for value in (first, last))
        top, bottom = (np.clip(value, 0, height - 1) // down for value in (top, bottom))
        return top, bottom, first, last

    def _inside(self, column, row):
        """Columns and rows relative to the sector's first, moved into the sector."""
        sector = self.sector
        width, height = sector.end_column - sector.first_column, sector.end_row - sector.first_row
        offset = (np.asarray(column) - sector.first_column) % self.columns
        # Columns after the sector that are nearer to its first one, around the hemisphere.
        offset = np.where(offset - (width - 1) > self.columns - offset, 0, offset)
        return np.clip(offset, 0, width - 1), np.clip(np.asarray(row) - sector.first_row, 0, height - 1)
