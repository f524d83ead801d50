"""Square scan: the words of squares that survival reads, level by level.

The counts are those of `hw.ctu.survival`; golden itself decides survival by `golden.engine.ctu.survival`.
"""

from dataclasses import dataclass, fields

import numpy as np

from golden.engine.config import Config
from golden.engine.ctu.grid_rays import GridRays
from golden.engine.ctu.sector import Sector, sector_rays
from golden.engine.ctu.survival import summed
from golden.engine.frustum import FrustumRecord
from golden.engine.icu.section_clip import SectionWindow, section_clip
from golden.engine.icu.window import Window

__all__ = ["FEW", "GROUP", "SIDE", "RowGroups", "row_groups", "scanned_words", "survival_words"]

# Neighbours in a row that are looked up together, at most; so few that each is looked up alone; squares of a word along
# each axis.
GROUP, FEW, SIDE = 8, 2, 4


@dataclass(frozen=True, kw_only=True, eq=False)
class RowGroups:
    """The grid rays of a shell that a section requests, row by row in groups of neighbours.

    Parameters
    ----------
    row, first, last, size
        G int64: row of each group, its first and last column, and its rays. Columns continue behind the last one at 0.
    columns
        Columns of the shell.
    """

    row: np.ndarray
    first: np.ndarray
    last: np.ndarray
    size: np.ndarray
    columns: int

    def rays(self, which: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Rows and columns of all rays of some groups."""
        group = which.repeat(self.size[which])
        number = np.arange(len(group)) - np.repeat(np.cumsum(self.size[which]) - self.size[which], self.size[which])
        return self.row[group], (self.first[group] + number) % self.columns


def row_groups(rays: GridRays, section: Sector, record: FrustumRecord) -> RowGroups:
    """The groups of a section's grid rays; a row begins with the ray behind the first gap, or with column 0."""
    requested = sector_rays(rays, section, record)
    count = requested.sum(axis=1)
    begins = requested & ~np.roll(requested, 1, axis=1)
    start = np.where(count < rays.columns, begins.argmax(axis=1), 0)
    groups = -(-count // GROUP)
    row = np.arange(rays.rows).repeat(groups)
    offset = GROUP * (np.arange(len(row)) - np.repeat(np.cumsum(groups) - groups, groups))
    size = np.minimum(GROUP, count[row] - offset)
    first = start[row] + offset
    return RowGroups(row=row, first=first % rays.columns, last=(first + size - 1) % rays.columns, size=size,
                     columns=rays.columns)


def survival_words(rays: GridRays, live: np.ndarray, section: Sector, record: FrustumRecord,
                   config: Config) -> tuple[list[int], int]:
    """Words that the survival test of a section's grid rays of a shell reads, by level from the tiles on; and windows.

    Neighbours are looked up together, from the highest level down. A group that a level finds dead ends there; each ray
    of one that all levels find live is looked up among the tiles.

    Parameters
    ----------
    rays
        Grid rays of the shell.
    live
        Live squares of the section (`SettlePyramid.live`).
    section
        The section of the frustum ``record``.

    Returns
    -------
    The words, and how many groups and rays alone are looked up.
    """
    levels = [live]
    for _ in range(1, config.ctu.pyramid_levels):
        levels.append(_coarser(levels[-1]))
    tile, words, groups = 1 << config.icu.tile_bits, [0] * len(levels), row_groups(rays, section, record)
    row, first, last = groups.row, groups.first, groups.last
    left, right = rays.first_column[row, first], rays.first_column[row, last] + rays.column_count[row, last]
    columns = right - left
    if not record.is_screen:
        columns = np.where(rays.column_count[row, first] == record.columns, record.columns, columns % record.columns)
    windows = _windows(rays, row, left, columns, section, record)
    few = groups.size <= FEW
    alive = np.flatnonzero(~few)
    lookups = len(alive)
    for level in reversed(range(len(levels))):
        read, is_live = scanned_words(_only(windows, alive), levels[level], tile * SIDE**level)
        words[level] += int(read.sum())
        alive = alive[is_live]
    alone = few.copy()
    alone[alive] = True
    row, column = groups.rays(np.flatnonzero(alone))
    windows = _windows(rays, row, rays.first_column[row, column], rays.column_count[row, column], section, record)
    words[0] += int(scanned_words(windows, live, tile)[0].sum())
    return words, lookups + len(row)


def scanned_words(window: SectionWindow, live: np.ndarray, side: int) -> tuple[np.ndarray, np.ndarray]:
    """Words read for each window until the first live square, row by row; and whether there is one.

    Parameters
    ----------
    window
        P windows.
    live
        Live squares of ``side`` x ``side`` rays.

    Returns
    -------
    P int64, at least 1, and P bool.
    """
    total = summed(live)
    some = window.row_count > 0
    top, bottom = window.row_first // side, (window.row_first + window.row_count - 1) // side
    left, right = window.column_first // side, (window.column_first + window.column_count - 1) // side
    wrapped = (window.wrapped_count - 1) // side
    front = np.where(window.column_count > 0, right // SIDE - left // SIDE + 1, 0)
    across = front + np.where(window.wrapped_count > 0, wrapped // SIDE + 1, 0)
    number = np.where(some, across * (bottom // SIDE - top // SIDE + 1), 0)
    words, alive = np.ones(len(some), dtype=np.int64), np.zeros(len(some), dtype=bool)
    word, left_over = 0, np.flatnonzero(number)
    while len(left_over):
        one = left_over
        row, column = divmod(word, across[one])
        row, second = row + top[one] // SIDE, column >= front[one]
        first, last = np.where(second, 0, left[one]), np.where(second, wrapped[one], right[one])
        column = first // SIDE + np.where(second, column - front[one], column)
        above, below = np.maximum(top[one], SIDE * row), np.minimum(bottom[one] + 1, SIDE * (row + 1))
        first, end = np.maximum(first, SIDE * column), np.minimum(last + 1, SIDE * (column + 1))
        found = total[below, end] - total[above, end] > total[below, first] - total[above, first]
        word += 1
        words[one], alive[one] = word, found
        left_over = one[~found & (word < number[one])]
    return words, alive


def _windows(rays, row, first, columns, section, record):
    return section_clip(Window(first, columns, rays.first_row[row], rays.row_count[row]), section, record)


def _only(window, which):
    return SectionWindow(*(getattr(window, field.name)[which] for field in fields(SectionWindow)))


def _coarser(live):
    """Squares of `SIDE` x `SIDE` squares."""
    rows, columns = (-(-size // SIDE) * SIDE for size in live.shape)
    whole = np.zeros((rows, columns), dtype=bool)
    whole[:live.shape[0], :live.shape[1]] = live
    return whole.reshape(rows // SIDE, SIDE, -1, SIDE).any(axis=(1, 3))
