"""Sky view factors that geometry decides."""

import numpy as np

from golden.light.factors.certain import TOUCH, certain_shares
from golden.light.factors.pair_factors import exchange_areas
from golden.light.factors.sides import Sides

__all__ = ["FEW_TESTS", "exact_sky"]

FEW_TESTS = 1 << 13
"""Pairs of a row times patches up to which deciding them costs less than rays."""

# Error of closed forms, and the least share that is no rounding of them.
_CLOSED_FORMS = 1e-8


def exact_sky(sides: Sides, rows: np.ndarray, row: np.ndarray, column: np.ndarray) -> np.ndarray:
    """1 minus the factors of a row where all of these are exact and it sees no black back; NaN of other rows.

    Parameters
    ----------
    rows
        R int, increasing: their numbers.
    row, column
        P int: the pairs of these rows with all sides that may face them.

    Returns
    -------
    R float64.
    """
    factor = exchange_areas(sides.vertices[row], sides.vertices[column]) / sides.area[row]
    own = np.searchsorted(rows, row)
    few = (np.bincount(own, minlength=len(rows)) * len(sides.scene) <= FEW_TESTS) & ~_may_see_backs(sides, rows)
    chosen = np.flatnonzero(few[own] & (factor > 0))
    decided, share = certain_shares(sides, row[chosen], column[chosen])
    few[own[chosen[~decided]]] = False
    rest = 1 - np.bincount(own[chosen], factor[chosen] * share, len(rows))
    return np.where(few & (rest > _CLOSED_FORMS * len(sides)), rest, np.nan)


def _may_see_backs(sides, rows):
    """Whether rows may see the back of a one-sided patch other than their own."""
    patches, touch = sides.scene, TOUCH * sides.scene.size
    black = np.flatnonzero(~patches.two_sided)
    normal, corners = patches.normals[black], patches.vertices[black].reshape(-1, 3)
    level = np.einsum("ni,ni->n", normal, patches.centres[black])
    behind = (sides.vertices[rows] @ normal.T - level).min(axis=1) < -touch
    rise = sides.normal[rows] @ corners.T - np.einsum("ri,ri->r", sides.normal[rows], sides.centre[rows])[:, None]
    above = rise.reshape(len(rows), -1, 4).max(axis=2, initial=-1) > touch
    return (behind & above & (sides.patch[rows][:, None] != black)).any(axis=1)
