import numpy as np
from scipy import sparse

from golden.light.factors.entry_pairs import entry_pairs


def test_mirrors_share_a_number():
    random = np.triu(np.random.default_rng(1).uniform(size=(30, 30)) < 0.2, 1)
    matrix = sparse.csr_array((random | random.T).astype(float))
    row, upper, pair = entry_pairs(matrix.indices, matrix.indptr)
    low, high = np.minimum(row, matrix.indices), np.maximum(row, matrix.indices)
    np.testing.assert_array_equal(row, matrix.tocoo().row)
    np.testing.assert_array_equal(low[upper][pair], low)
    np.testing.assert_array_equal(high[upper][pair], high)
    assert len(upper) == random.sum()


def test_no_entries():
    row, upper, pair = entry_pairs(np.zeros(0, np.int32), np.zeros(4, np.int32))
    assert (len(row), len(upper), len(pair)) == (0, 0, 0)
