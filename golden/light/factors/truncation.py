"""View factors without small entries, whose rows still close."""

from dataclasses import replace

import numpy as np
from scipy import sparse

from golden.light.factors.entry_pairs import entry_pairs
from golden.light.factors.view_factors import ViewFactors

__all__ = ["truncated"]


def truncated(factors: ViewFactors, least: float) -> ViewFactors:
    """The factors without the pairs whose both factors are below ``least``; each row adds what it lost to F_ii.

    So rows sum to what they did, A_i F_ij = A_j F_ji stays, and no factor is negative: what a patch loses counts as if
    it came from the patch itself. A scene at one temperature stays in equilibrium.

    Parameters
    ----------
    factors
        Of N patches, reciprocal, none of which sees itself.
    least
        The larger factor of a pair from which on it stays.
    """
    F, count = factors.F, len(factors)
    row, first, pair = entry_pairs(F.indices, F.indptr)
    larger = F.data[first] * np.maximum(1, factors.area[row[first]] / factors.area[F.indices[first]])
    lost = (larger < least)[pair]
    column = np.where(lost, row, F.indices)

    def matrix(values):
        return sparse.coo_array((values, (row, column)), shape=(count, count)).tocsr()

    error = None
    if factors.error is not None:
        variance = matrix(factors.error.data**2)
        error = sparse.csr_array((np.sqrt(variance.data), variance.indices, variance.indptr), shape=variance.shape)
    return replace(factors, F=matrix(F.data), error=error, settings=factors.settings | {"drop_below": least},
                   unprojected=None if factors.unprojected is None else matrix(factors.unprojected.data))
