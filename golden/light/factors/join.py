"""Rows of view factors joined: one estimate for the two directions of each pair."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from golden.light.factors.row_block import RowBlock

__all__ = ["Estimate", "join"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Estimate:
    """Reciprocal view factors of N sides, before the projection.

    Parameters
    ----------
    F
        N x N csr_array: view factors from row to column; an entry wherever either direction was seen.
    error
        csr_array of the same pattern: standard errors, 0 where a factor is exact.
    sky, back
        N float64: shares of the rays that leave the scene, and that meet the black back of a one-sided patch.
    sky_error, back_error
        N float64: their standard errors; 0 where no ray did.
    hidden_error
        The largest standard error of a factor that is no entry.
    """

    F: sparse.csr_array
    error: sparse.csr_array
    sky: np.ndarray
    back: np.ndarray
    sky_error: np.ndarray
    back_error: np.ndarray
    hidden_error: float


def join(blocks: Sequence[RowBlock], *, area: np.ndarray, error: float) -> Estimate:
    """Join the rows of all sides.

    Of a pair that segments measured their result counts, the surer one of two, for both directions. Any other pair has
    a factor below ``error`` / 2 from the smaller patch, and gets the hits of both hemispheres: (k_i + k_j) /
    (n_i / A_i + n_j / A_j), at most ``error`` from the smaller patch.

    Parameters
    ----------
    blocks
        The rows, in order.
    area
        N float64, areas of the sides.
    error
        Of the `FactorRows`.
    """
    width = len(area)
    row = np.repeat(np.arange(width), np.concatenate([np.diff(block.start) for block in blocks]))
    column, hits, factor, wrong = (np.concatenate([getattr(block, name) for block in blocks])
                                   for name in ("column", "hits", "factor", "error"))
    low, high = np.minimum(row, column), np.maximum(row, column)
    key, pair = np.unique(low.astype(np.int64) * width + high, return_inverse=True)
    low, high = np.divmod(key, width)
    smaller = np.minimum(area[low], area[high])
    rays, sky, back, sky_error, hidden = (
        np.concatenate([np.atleast_1d(getattr(block, name)) for block in blocks])
        for name in ("rays", "sky", "back", "sky_error", "hidden_error"))
    exposure = rays[low] / area[low] + rays[high] / area[high]
    count = np.bincount(pair, hits, len(key))
    exchange = np.minimum(count / exposure, error * smaller)
    deviation = np.minimum(np.sqrt(count + 0.5) / exposure, error / 2 * smaller)
    measured = np.flatnonzero(~np.isnan(factor))
    wrong, factor = ((values * area[row])[measured] for values in (wrong, factor))
    # The surest one is written last.
    order = np.argsort(-wrong, kind="stable")
    pair = pair[measured[order]]
    exchange[pair], deviation[pair] = factor[order], wrong[order]
    middle = (back + 0.5) / (rays + 1)
    return Estimate(F=_both(exchange, low, high, area), error=_both(deviation, low, high, area), sky=sky / rays,
                    back=back / rays, sky_error=sky_error, hidden_error=float(hidden.max(initial=0)),
                    back_error=np.where(back > 0, np.sqrt(middle * (1 - middle) / (rays + 1)), 0.0))


def _both(exchange, low, high, area):
    """The rows of a symmetric matrix divided by the areas, as a sorted csr_array that keeps its zeros."""
    row, column = np.concatenate([low, high]), np.concatenate([high, low])
    matrix = sparse.coo_array((np.concatenate([exchange, exchange]) / area[row], (row, column)),
                              shape=(len(area), len(area))).tocsr()
    matrix.sort_indices()
    return matrix
