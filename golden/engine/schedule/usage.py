"""Effectiveness and cumulative usage frequency of a set of patches.

A reference is the test of one ray against one patch; the frequency of a patch is its number of references.
"""

import numpy as np

__all__ = ["cumulative_frequency", "effectiveness", "usage_order"]


def usage_order(frequency) -> np.ndarray:
    """U: the numbers of all patches, most used first; among equally used ones the smaller number first."""
    frequency = np.asarray(frequency)
    return np.lexsort((np.arange(len(frequency)), -frequency.astype(np.int64)))


def effectiveness(dense, sparse) -> np.ndarray:
    """E(k): the references to the k patches most used by a sparse casting, as a share of those to the best k patches.

    Parameters
    ----------
    dense, sparse
        N int, frequency of each patch in the castings to be served, and in the sparse casting.

    Returns
    -------
    E(1) ... E(N') float64, where N' patches were found by the sparse casting; 1 where the best k have no references.

    Source: Shen 1993, Eq. 5.1, with the dense frequency above the line too (printed there with the sparse one).
    """
    dense = np.asarray(dense)
    found = np.count_nonzero(sparse)
    served = np.cumsum(dense[usage_order(sparse)[:found]])
    best = np.cumsum(dense[usage_order(dense)[:found]])
    return np.where(best > 0, served / np.maximum(best, 1), 1.0)


def cumulative_frequency(dense, chosen) -> float:
    """CUF: the share of all references that goes to the ``chosen`` patches (numbers); 1 without references.

    Source: Shen 1993, section 6.2.
    """
    dense = np.asarray(dense)
    return float(dense[np.asarray(chosen, dtype=np.int64)].sum() / dense.sum()) if dense.any() else 1.0
