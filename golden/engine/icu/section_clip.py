"""Section clip: the part of a window in a cluster's section."""

from dataclasses import dataclass

import numpy as np

from golden.engine.ctu.sector import Sector
from golden.engine.frustum import FrustumRecord
from golden.engine.icu.window import Window

__all__ = ["SectionWindow", "section_clip"]


@dataclass(frozen=True, eq=False)
class SectionWindow:
    """Windows of P patches relative to the section's first column and row.

    A window is ``row_count`` rows from ``row_first``, by ``column_count`` columns from ``column_first`` and, where it
    wraps, ``wrapped_count`` further columns from 0. P int64 each; all are 0 without rays in the section.
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
    """The part of each window in ``section``."""
    across, down = section.end_column - section.first_column, section.end_row - section.first_row
    first = window.column_first - section.first_column
    last = first + window.column_count
    front = np.where(first >= 0, np.clip(np.minimum(last, across) - first, 0, None), 0)
    # A window that begins before the section extends into it; one that passes the frustum's last column wraps to the
    # first.
    over = np.where(first < 0, last, last - (0 if record.is_screen else record.columns))
    wrapped = np.where((first < 0) | (not record.is_screen), np.clip(np.minimum(over, across), 0, None), 0)
    top = np.maximum(window.row_first - section.first_row, 0)
    bottom = np.minimum(window.row_first + window.row_count - section.first_row, down)
    some = (bottom > top) & (front + wrapped > 0)
    alone = some & (front == 0)
    return SectionWindow(*(np.where(some, value, 0) for value in (
        np.where(alone | (first < 0), 0, first), np.where(alone, wrapped, front), np.where(alone, 0, wrapped),
        top, bottom - top)))
