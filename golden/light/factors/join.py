"""Rows of view factors joined: one estimate for the two directions of each pair."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from scipy import sparse

from golden.light.factors.entry_pairs import entry_pairs
from golden.light.factors.row_block import RowBlock

__all__ = ["Estimate", "join"]

# Of the positions of entries.
_BITS = 32


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
        N float64: their standard errors; of the back 0 where no ray did.
    unseen_error
        N float64: standard errors of the share of a row that is no entry.
    hidden_error
        The largest standard error of a factor that is no entry.
    """

    F: sparse.csr_array
    error: sparse.csr_array
    sky: np.ndarray
    back: np.ndarray
    sky_error: np.ndarray
    back_error: np.ndarray
    unseen_error: np.ndarray
    hidden_error: float

    @property
    def closed_sky_error(self) -> np.ndarray:
        """Standard errors of the sky's shares in closed rows, N float64: all else in a row measures them once more."""
        others = self.error.power(2).sum(axis=1) + self.back_error**2 + self.unseen_error**2
        own = self.sky_error**2
        return np.sqrt(np.divide(own * others, own + others, out=np.zeros_like(own), where=own > 0))


def join(blocks: Sequence[RowBlock], *, area: np.ndarray, error: float) -> Estimate:
    """Join the rows of all sides.

    Of a pair that segments measured, the result with the smaller standard error counts, for both directions. Any other
    pair has a factor below ``error`` / 2 from the smaller patch. Its exchange area follows from the hits k of both
    hemispheres of n rays: (k_i + k_j) / (n_i / A_i + n_j / A_j), at most ``error`` times the smaller area.

    Parameters
    ----------
    blocks
        The rows, in order.
    area
        N float64, areas of the sides.
    error
        Of the `FactorRows`.
    """
    def joined(name):
        return np.concatenate([getattr(block, name) for block in blocks])

    width = len(area)
    rays, sky, back = (joined(name) for name in ("rays", "sky", "back"))
    indices, indptr, position = _both_directions(
        joined("column"), np.cumsum(np.concatenate([[0], *(np.diff(block.start) for block in blocks)])), width)
    row, upper, pair = entry_pairs(indices, indptr)
    low, high = row[upper], indices[upper]
    # What is no entry stands last.
    forth, reverse = ((positions - 1).astype(np.int32) for positions in (position[upper] & (1 << _BITS) - 1,
                                                                      position[upper] >> _BITS))
    del position, upper

    def both(name, last):
        values = np.append(joined(name), last)
        return values[forth], values[reverse]

    count = np.add(*both("hits", 0))
    smaller = np.minimum(area[low], area[high])
    exposure = rays[low] / area[low] + rays[high] / area[high]
    exchange = np.minimum(count / exposure, error * smaller)
    deviation = np.minimum(np.sqrt(count + 0.5) / exposure, error / 2 * smaller)
    del count, exposure, smaller
    own, others = (np.where(np.isnan(values), np.inf, values) for values in both("error", np.inf))
    own, others = own * area[low], others * area[high]
    least = np.minimum(own, others)
    measured = np.isfinite(least)
    deviation[measured] = least[measured]
    is_own = own < others
    del own, others, least
    own, others = both("factor", np.nan)
    exchange[measured] = np.where(is_own, own * area[low], others * area[high])[measured]
    del own, others, low, high
    middle = (back + 0.5) / (rays + 1)
    F, spread = (sparse.csr_array((values[pair] / area[row], indices, indptr), shape=(width, width))
                 for values in (exchange, deviation))
    return Estimate(F=F, error=spread, sky=sky, back=back / rays, sky_error=joined("sky_error"),
                    # Wilson's of what no ray met, as in `golden.light.factors.replicate_shares`.
                    unseen_error=2 / (rays + 4),
                    hidden_error=float(joined("hidden_error").max(initial=0)),
                    back_error=np.where(back > 0, np.sqrt(middle * (1 - middle) / (rays + 1)), 0.0))


def _both_directions(column, start, width):
    """Indices and indptr of all entries and their mirrors; 1 + an entry's position, and 1 + its mirror's in upper bits.

    Positions are 0 where there is no such entry.
    """
    position = np.arange(1, len(column) + 1)
    forth = sparse.csr_array((position, column, start), shape=(width, width))
    reverse = sparse.csr_array((position << _BITS, column, start), shape=(width, width)).T.tocsr()
    both = forth + reverse
    both.sort_indices()
    # The sum's arrays are parts of longer ones.
    return both.indices.copy(), both.indptr, both.data
