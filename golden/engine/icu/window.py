"""Windows: the part of a frustum's grid of rays that may hit a patch."""

from dataclasses import dataclass

import numpy as np

from golden.engine.frustum import FrustumRecord

__all__ = ["Window", "make_window"]


@dataclass(frozen=True, eq=False)
class Window:
    """Windows of P patches: ``column_count`` columns from ``column_first`` by ``row_count`` rows from ``row_first``.

    In a hemisphere columns wrap from the last to the first. P int64 each. A window without rays has counts of 0.
    """

    column_first: np.ndarray
    column_count: np.ndarray
    row_first: np.ndarray
    row_count: np.ndarray

    def __getitem__(self, rows) -> "Window":
        return Window(self.column_first[rows], self.column_count[rows], self.row_first[rows], self.row_count[rows])

    def only(self, which: np.ndarray) -> "Window":
        """The windows of the patches ``which`` (P bool); all other windows are empty."""
        return Window(*(np.where(which, value, 0) for value in
                        (self.column_first, self.column_count, self.row_first, self.row_count)))

    @property
    def rays(self) -> np.ndarray:
        """P int64: rays in the window."""
        return self.column_count * self.row_count

    def holds(self, column, row, columns: int) -> np.ndarray:
        """Whether rays are in their windows; the window's entries broadcast with ``column`` and ``row``."""
        return ((column - self.column_first) % columns < self.column_count) \
            & (row >= self.row_first) & (row - self.row_first < self.row_count)

    def pairs(self, columns: int) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """All rays of all windows: number of the window, column and row, window by window and row by row."""
        count = self.rays
        window = np.repeat(np.arange(len(count)), count)
        rank = np.arange(len(window)) - np.repeat(np.cumsum(count) - count, count)
        row, column = np.divmod(rank, self.column_count[window])
        return window, (self.column_first[window] + column) % columns, self.row_first[window] + row


def make_window(record: FrustumRecord, never, column_first, column_last, row_first, row_last) -> Window:
    """Windows from first and last indices: rows are clipped to the grid, columns clipped (screen) or wrapped.

    ``never`` (P bool): the window is empty.
    """
    if record.is_screen:
        column_first, column_last = np.maximum(column_first, 0), np.minimum(column_last, record.columns - 1)
    row_first, row_last = np.maximum(row_first, 0), np.minimum(row_last, record.rows - 1)
    columns, rows = column_last - column_first + 1, row_last - row_first + 1
    some = ~never & (columns > 0) & (rows > 0)
    return Window(np.where(some, column_first % record.columns, 0), np.where(some, columns, 0),
                  np.where(some, row_first, 0), np.where(some, rows, 0))
