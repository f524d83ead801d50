"""Row pieces: how often the generator of grid rays searches for the columns of a section, row by row.

The counts are those of `hw.ctu.row_pieces`; golden itself decides by `golden.engine.ctu.sector`.
"""

from dataclasses import dataclass

import numpy as np

from golden.engine.ctu.grid_rays import INDEX_FRACTION, GridRays
from golden.engine.ctu.sector import Sector
from golden.engine.frustum import FrustumRecord

__all__ = ["RowPieces", "row_pieces"]

# Positions before and behind all columns.
_LOWEST, _HIGHEST = np.iinfo(np.int64).min, np.iinfo(np.int64).max


@dataclass(frozen=True, kw_only=True, eq=False)
class RowPieces:
    """The rows of grid rays of a shell that a section requests.

    Parameters
    ----------
    row
        R int64: the rows.
    pieces
        R int64: arcs of each row, two of a section that continues behind the last column at 0.
    searches
        R int64: arcs of it whose ends lie between other columns than those of the last row with such an arc.
    """

    row: np.ndarray
    pieces: np.ndarray
    searches: np.ndarray


def row_pieces(rays: GridRays, section: Sector, record: FrustumRecord) -> RowPieces:
    """The rows of a section without subshell lists."""
    row = np.flatnonzero(
        (rays.row_position >= (section.first_row << INDEX_FRACTION) - rays.row_border)
        & (rays.row_position <= (section.end_row << INDEX_FRACTION) + rays.row_border))
    border = rays.column_border[row]
    low = (section.first_column << INDEX_FRACTION) - border
    end = (section.end_column << INDEX_FRACTION) + border + 1
    is_second = np.zeros(len(row), dtype=bool)
    over = np.full(len(row), _LOWEST)
    if not record.is_screen:
        around = record.columns << INDEX_FRACTION
        is_whole, begins_before, goes_over = end >= low + around, low < 0, end > around
        is_second = ~is_whole & (begins_before | goes_over)
        over = np.where(begins_before, end, end - around)
        low = np.where(is_whole, _LOWEST, np.where(begins_before, low + around, low))
        end = np.where(is_whole | begins_before | goes_over, _HIGHEST, end)
    searches = _searches(rays, low, end) + np.where(
        is_second, _searches(rays, np.full(len(row), _LOWEST), over, among=is_second), 0)
    return RowPieces(row=row, pieces=1 + is_second, searches=searches)


def _searches(rays, low, end, among=None):
    """0 or 1 for each row with an arc: whether its ends lie between other columns than those searched for before."""
    found = np.zeros(len(low), dtype=np.int64)
    which = np.flatnonzero((low < end) & (True if among is None else among))
    ends = np.searchsorted(rays.column_position, np.stack([low[which], end[which]]))
    # An arc that has been found before has the same columns as the one before it, as only a search changes them.
    found[which] = np.concatenate([[1], (ends[:, 1:] != ends[:, :-1]).any(axis=0)])[:len(which)]
    return found
