from dataclasses import replace

import numpy as np
import pytest
from scipy import sparse

from golden.light.factors.truncation import truncated
from golden.light.factors.view_factors import ViewFactors


def four_sides():
    """Sides of areas 1, 2, 4 and 8, all pairs with an exchange area of their own; errors are a tenth of the factors."""
    area = np.array([1.0, 2, 4, 8])
    exchange = np.array([[0, 0.1, 0.2, 0.3], [0.1, 0, 0.04, 0.06], [0.2, 0.04, 0, 0.7], [0.3, 0.06, 0.7, 0]])
    F = sparse.csr_array(exchange / area[:, None])
    return ViewFactors(F=F, error=sparse.csr_array((F.data / 10, F.indices, F.indptr), shape=F.shape),
                       unprojected=sparse.csr_array((F.data * 2, F.indices, F.indptr), shape=F.shape),
                       sky=1 - F.sum(axis=1), back=np.zeros(4), area=area, normal=np.eye(4)[:, :3],
                       surface=np.array(["a"] * 4), patch=np.arange(4), front=np.ones(4, dtype=bool))


def test_pairs_with_both_factors_below_the_limit_move_to_the_diagonal():
    """Of 1-2 the factors are 0.02 and 0.01, of 1-3 0.03 and 0.0075: both are lost; 0-3 keeps 0.3 and 0.0375."""
    factors = four_sides()
    found = truncated(factors, 0.035)
    F = factors.F.toarray()
    expected = F.copy()
    for i, j in ((1, 2), (1, 3)):
        expected[i, i] += F[i, j]
        expected[j, j] += F[j, i]
        expected[i, j] = expected[j, i] = 0
    np.testing.assert_allclose(found.F.toarray(), expected, atol=1e-15)
    assert found.F.nnz == np.count_nonzero(expected)
    np.testing.assert_allclose(found.unprojected.toarray(), 2 * expected, atol=1e-15)
    error = found.error.toarray()
    assert error[1, 1] == pytest.approx(np.hypot(0.002, 0.003))
    assert error[2, 2] == pytest.approx(0.001)
    assert error[0, 3] == pytest.approx(0.03)
    assert found.settings["drop_below"] == 0.035


@pytest.mark.parametrize("least", [1e-9, 0.011, 0.035, 0.2, 1])
def test_closure_and_reciprocity_stay_at_any_limit(least):
    found = truncated(four_sides(), least)
    assert found.closure < 1e-14
    assert found.reciprocity < 1e-14


@pytest.mark.parametrize("least", [1e-9, 0.011, 0.035, 0.2, 1])
@pytest.mark.parametrize("hidden_error", [0.0, 0.02, 0.9])
def test_the_bound_of_an_absent_factor_holds_for_those_that_were_dropped(least, hidden_error):
    factors = replace(four_sides(), hidden_error=hidden_error, settings={"error": 0.2})
    found = truncated(factors, least)
    lost = (factors.F.toarray() > 0) & (found.F.toarray() == 0)
    possible = (factors.F.toarray() + 2 * factors.error.toarray())[lost]
    assert found.largest_absent >= max(possible.max(initial=0), factors.largest_absent)


def test_a_limit_that_a_factor_equals_keeps_it():
    assert truncated(four_sides(), 0.03).F.toarray()[1, 3] == 0.03
