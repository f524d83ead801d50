"""Where patches are cut along their bilinear coordinates."""

import numpy as np

from golden.base.compiled import compiled

__all__ = ["Cuts"]


class Cuts:
    """Cells of N patches, nu x nv each: of one size in (u, v), or between given knots.

    Parameters
    ----------
    counts
        N x 2: cells along u and along v.
    knots
        By patch the knots along u and along v, ascending from 0 to 1, one more than cells each. Default: none.

    Members
    -------
    counts
        As given.
    """

    def __init__(self, counts: np.ndarray, knots: dict[int, tuple[np.ndarray, np.ndarray]] | None = None):
        self.counts = counts
        knots = knots or {}
        # The knots of the patch with number k among these are moved by 2 k: one ascending array along each axis.
        self._place = np.full(len(counts), -1)
        self._place[list(knots)] = 2 * np.arange(len(knots))
        self._knots = [np.concatenate([own[axis] + 2.0 * k for k, own in enumerate(knots.values())])
                       if knots else np.zeros(0) for axis in (0, 1)]
        lengths = np.array([[len(own[axis]) for own in knots.values()] for axis in (0, 1)], dtype=np.int64)
        self._start = np.zeros((2, len(counts)), dtype=np.int64)
        self._start[:, list(knots)] = np.cumsum(lengths, axis=1) - lengths

    def has_knots(self, patch: np.ndarray) -> np.ndarray:
        """K bool: whether patches are cut between knots."""
        return self._place[patch] >= 0

    def cells(self, patch: np.ndarray, axis: int, place: np.ndarray) -> np.ndarray:
        """Places from 0 to 1 along u (``axis`` 0) or v (1) of K patches, in cells."""
        result = np.empty(len(place))
        _cells(patch, place, self.counts[:, axis], self._place, self._knots[axis], self._start[axis], result)
        return result

    def places(self, patch: np.ndarray, axis: int, cells: np.ndarray) -> np.ndarray:
        """The inverse of `cells`."""
        result = cells / self.counts[patch, axis]
        some = np.flatnonzero(self.has_knots(patch))
        if len(some):
            knots, start = self._knots[axis], self._start[axis, patch[some]]
            low = start + np.clip(cells[some].astype(np.int64), 0, self.counts[patch[some], axis] - 1)
            share = cells[some] - (low - start)
            result[some] = (1 - share) * knots[low] + share * knots[low + 1] - self._place[patch[some]]
        return result


@compiled
def _cells(patch, place, counts, number, knots, start, result):
    for k in range(len(patch)):
        own = patch[k]
        if number[own] < 0:
            result[k] = place[k] * counts[own]
            continue
        moved = min(max(place[k], 0.0), 1.0) + number[own]
        low = np.searchsorted(knots, moved, side="right") - 1
        low = min(max(low, start[own]), start[own] + counts[own] - 1)
        result[k] = low - start[own] + (moved - knots[low]) / (knots[low + 1] - knots[low])
