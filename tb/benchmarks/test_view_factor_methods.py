import numpy as np
import pytest
from scipy import sparse

from benchmarks.view_factor_cases import box_in_box
from benchmarks.view_factor_methods import METHODS, method_rows
from golden.light.factors.join import Estimate


def duct(factor):
    """A triangular duct with sides 3, 4 and 5, of which one factor is off, and its sides."""
    F, area = np.array([(0, 1 / 3, 2 / 3), (1 / 4, 0, 3 / 4), (2 / 5, 3 / 5, 0)]), np.array([3.0, 4, 5])
    F[:2, :2] *= factor
    error = sparse.csr_array((F > 0) * 0.1 / area[:, None])
    zeros = np.zeros(3)
    return Estimate(F=sparse.csr_array(F), error=error, sky=zeros, back=zeros, sky_error=zeros, back_error=zeros,
                    unseen_error=zeros, hidden_error=0.0), area


@pytest.mark.parametrize("name", [name for name in METHODS if name != "none"])
def test_rows_close_and_pairs_are_reciprocal(name):
    estimate, area = duct(1.05)
    F = METHODS[name](estimate, area)
    np.testing.assert_allclose(F.sum(axis=1), 1, rtol=0, atol=1e-9)
    np.testing.assert_allclose(area[:, None] * F, (area[:, None] * F).T, rtol=0, atol=1e-12)
    assert (np.diag(F) == 0).all()


def test_the_methods_differ():
    found = [method(*duct(1.02)) for method in METHODS.values()]
    # Of a triangle closure and reciprocity leave one solution.
    for F in found[1:]:
        np.testing.assert_allclose(F, found[1], rtol=0, atol=1e-9)
    assert np.abs(found[0] - found[1]).max() > 1e-3


def test_the_built_one_alone_keeps_exact_factors_and_errs_least():
    rows = {name: values for name, *values in method_rows(box_in_box(0.6).facets, coarse=5e-2, fine=5e-3)}
    built = rows["the same within two standard errors (built)"]
    scaled = rows["symmetric Sinkhorn scaling"]
    assert built[0] < 1e-9 < rows["none"][0]
    assert built[2] < 1e-6 < scaled[2]
    assert built[3] <= scaled[3]
