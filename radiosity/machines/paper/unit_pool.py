"""Unit pool: how many traversal units each intersection unit is joined with, and the sectors that these cast."""

from collections.abc import Sequence

import numpy as np

from golden.base.errors import InputError
from golden.engine.ctu.sector import Sector
from golden.engine.schedule.sections import cut_sections

__all__ = ["join_units", "sector_cuts"]


def join_units(steps: Sequence[float], sections: Sequence[Sector], *, units: int) -> tuple[int, ...]:
    """Traversal units of each cluster.

    Each cluster has one. Then the one with most expected steps for a unit gets as many again, as long as the pool has
    so many left and the section can be cut for them. Of equal ones the first cluster does.

    Parameters
    ----------
    steps
        Expected steps of each section.
    sections
        The sections.
    units
        Traversal units of the pool, at least one for each section.

    Raises
    ------
    InputError
        There are fewer units than sections.

    Source: Shen & Deprettere, section 1.3.2; the rule is our choice.
    """
    if units < len(sections):
        raise InputError(f"machine: Traversal units must be at least {len(sections)}, one for each cluster, not "
                         f"{units}", parameter="traversal_units")
    joined, free = np.ones(len(sections), dtype=np.int64), units - len(sections)
    while True:
        share = np.where([2 * count <= _most(section) and count <= free for count, section in zip(
            joined.tolist(), sections, strict=True)], np.asarray(steps) / joined, -1)
        if share.max() < 0:
            return tuple(joined.tolist())
        chosen = share.argmax()
        free -= int(joined[chosen])
        joined[chosen] *= 2


def sector_cuts(steps: np.ndarray, section: Sector, *, units: int) -> tuple[Sector, ...]:
    """The sectors of a section: as many parts of about equal steps.

    Parameters
    ----------
    steps
        Rows x columns float64 of the whole frustum: expected steps of each ray.
    section, units
        The section, and its traversal units: a power of two.
    """
    own = steps[section.first_row:section.end_row, section.first_column:section.end_column]
    return tuple(Sector(section.first_column + part.first_column, section.first_column + part.end_column,
                        section.first_row + part.first_row, section.first_row + part.end_row)
                 for part in cut_sections(own, clusters=units).sections)


def _most(section):
    """Parts that alternate cuts, of columns first, can make of a section."""
    columns, rows = section.end_column - section.first_column, section.end_row - section.first_row
    levels = 0
    while columns >> (levels + 2) // 2 and rows >> (levels + 1) // 2:
        levels += 1
    return 1 << levels
