"""Settle pyramid: the smallest settle code of each square of rays, for the survival test."""

import numpy as np

from golden.engine.config import Config
from golden.engine.ctu.sector import Sector
from golden.engine.icu.settle_code import settle_code

__all__ = ["SettlePyramid"]


class SettlePyramid:
    """Squares of 2^``config.icu.tile_bits`` rays, counted from the section's first column and row.

    A square's code is the smallest of its rays' codes: if it is settled, all its rays are. Codes only grow, so a
    survival test on outdated codes keeps a superset.

    Parameters
    ----------
    codes
        rows x columns int64, settle codes of the section's rays.
    config
        The configuration.

    Members
    -------
    squares
        int64, the smallest code of each square; rays outside the section do not count.
    """

    def __init__(self, codes: np.ndarray, config: Config):
        self._bits = config.icu.tile_bits
        side = 1 << self._bits
        rows, columns = codes.shape
        whole = np.full((-(-rows // side) * side, -(-columns // side) * side), config.icu.settle.high)
        whole[:rows, :columns] = codes
        self.squares = whole.reshape(len(whole) // side, side, -1, side).min(axis=(1, 3))

    @classmethod
    def of(cls, inverse: np.ndarray, section: Sector, config: Config) -> "SettlePyramid":
        """The pyramid of a section from the stored inverse distances of all rays of the frustum, rows x columns."""
        own = inverse[section.first_row:section.end_row, section.first_column:section.end_column]
        return cls(settle_code(own, config), config)

    def live(self, threshold: int) -> np.ndarray:
        """Whether each square holds a code below the threshold: bool."""
        return self.squares < threshold

    def touched(self, first: np.ndarray, count: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Half-open ranges of the squares that hold ``count`` columns, or rows, from ``first``: first, and end."""
        some = count > 0
        return np.where(some, first >> self._bits, 0), np.where(some, (first + count - 1 >> self._bits) + 1, 0)
