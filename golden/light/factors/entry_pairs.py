"""Entries of a symmetric pattern that belong to the same pair."""

import numpy as np
from scipy import sparse

__all__ = ["entry_pairs"]


def entry_pairs(indices: np.ndarray, indptr: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """The rows of entries, the entries above the diagonal, and for each entry the number of that of its pair.

    Parameters
    ----------
    indices, indptr
        Of a CSR matrix of N rows with E entries, sorted, none on the diagonal; with each its mirror is an entry.

    Returns
    -------
    E int32; P int64 positions; and E int32, numbers 0 to P - 1.
    """
    count = len(indptr) - 1
    row = np.repeat(np.arange(count, dtype=np.int32), np.diff(indptr))
    upper = np.flatnonzero(row < indices)
    pair = np.zeros(len(indices), dtype=np.int32)
    pair[upper] = np.arange(len(upper))
    # Transposed, the numbers of entries above the diagonal stand at their mirrors.
    pair += sparse.csr_array((pair, indices, indptr), shape=(count, count)).T.tocsr().data
    return row, upper, pair
