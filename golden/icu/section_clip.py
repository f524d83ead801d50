"""Section clip: the part of a window that belongs to a cluster's section."""

from dataclasses import dataclass

import numpy as np

from golden.ctu.sector import Sector
from golden.frustum import FrustumRecord
from golden.icu.window import Window

__all__ = ["SectionWindow", "section_clip"]


@dataclass(frozen=True, eq=False)
class SectionWindow:
    """Of P patches, counted from the section's first column and row: ``column_count`` columns from ``column_first`` on
    and, where the window goes round, ``wrapped_count`` others from 0 on, by ``row_count`` rows from ``row_first`` on.

    P int64 each; all are 0 in a window without rays in the section.
    """

    column_first: np.ndarray
    column_count: np.ndarray
    wrapped_count: np.ndarray
    row_first: np.ndarray
    row_count: np.ndarray

    @property
    def rays(self) -> np.ndarray:
        """P int64: rays in the window and the section."""
        return (self.column_count + self.wrapped_count) * self.row_count


def section_clip(window: Window, section: Sector, record: FrustumRecord) -> SectionWindow:
    """The windows' parts in ``section``."""
    across, down = section.end_column - section.first_column, section.end_row - section.first_row
    first = window.column_first - section.first_column
    last = first + window.column_count
    front = np.where(first >= 0, np.clip(np.minimum(last, across) - first, 0, None), 0)
    # What begins before the section reaches into it from there, what goes on after the frustum's last column begins
    # anew at the first one.
    over = np.where(first < 0, last, last - (0 if record.is_screen else record.columns))
    wrapped = np.where((first < 0) | (not record.is_screen), np.clip(np.minimum(over, across), 0, None), 0)
    top = np.maximum(window.row_first - section.first_row, 0)
    bottom = np.minimum(window.row_first + window.row_count - section.first_row, down)
    some = (bottom > top) & (front + wrapped > 0)
    alone = some & (front == 0)
    return SectionWindow(*(np.where(some, value, 0) for value in (
        np.where(alone | (first < 0), 0, first), np.where(alone, wrapped, front), np.where(alone, 0, wrapped),
        top, bottom - top)))
