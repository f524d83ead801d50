import numpy as np
import pytest
from scipy import sparse

from golden.base.errors import InputError
from tb.golden.light.factors.samples import three_sides


def test_figures_of_three_sides():
    factors = three_sides()
    assert len(factors) == 3
    assert factors.closure == pytest.approx(0, abs=1e-15)
    # A F is 0.9 and 1 between the first two, 1.8 and 2 between the outer ones, equal between the others.
    assert factors.reciprocity == pytest.approx(2 * (0.1 + 0.2) / (0.9 + 1 + 1.8 + 2 + 3 + 3))
    assert factors.largest_error == pytest.approx(2 * 0.0075)
    assert three_sides(hidden_error=0.25).largest_error == 0.5
    assert factors.infeasible.tolist() == []
    assert three_sides(sky=np.array([0.06, 1e-6, 0])).infeasible.tolist() == [1]
    assert factors.largest_change == pytest.approx(0.0075)
    assert factors.sky_change == pytest.approx(0.02)
    assert factors.largest_sky_error == pytest.approx(0.02)
    assert factors.largest_sky_patch_error == pytest.approx(0.006)


@pytest.mark.parametrize(("hidden", "error", "bound"), [
    (0.001, 0.01, 0.005), (0.004, 0.01, 0.008), (0.004, None, 0.008)])
def test_a_factor_without_an_entry_has_a_bound(hidden, error, bound):
    """Twice its standard error where segments measured it, half of the request where rays alone might have met it."""
    settings = {} if error is None else {"error": error}
    assert three_sides(hidden_error=hidden, settings=settings).largest_absent == pytest.approx(bound)


def test_what_is_not_known_is_none():
    factors = three_sides(error=None, unprojected=None, unprojected_sky=None, sky_error=None)
    assert three_sides(sky_patches_error=None).largest_sky_patch_error is factors.largest_absent is None
    assert factors.largest_error is factors.largest_change is factors.sky_change is factors.largest_sky_error is None


def test_figures_without_entries():
    none = sparse.csr_array((3, 3))
    factors = three_sides(F=none, error=none, unprojected=none, sky=np.full(3, 0.75), back=np.full(3, 0.25))
    assert (factors.closure, factors.reciprocity, factors.largest_error, factors.largest_change) == (0, 0, 0.002, 0)


@pytest.mark.parametrize(("changed", "message"), [
    ({"sky": np.zeros(2)}, "sky must be 3, not"), ({"normal": np.zeros((3, 2))}, "normal must be 3 x 3"),
    ({"area": np.array([1.0, np.nan, 1])}, "area must be finite"), ({"sky": np.array([0, -0.1, 0])}, "at least 0"),
    ({"F": sparse.csr_array(-np.eye(3)), "error": None, "unprojected": None}, "F must be at least 0"),
    ({"sky_patches": sparse.csr_array(np.zeros((2, 145)))}, "sky_patches must be 3 x 145"),
    ({"error": sparse.csr_array(np.eye(3))}, "error must have the pattern of F")])
def test_parts_that_do_not_belong_together_are_refused(changed, message):
    with pytest.raises(InputError, match=message):
        three_sides(**changed)


def test_what_follows_from_the_arrays_follows_their_changes():
    factors = three_sides()
    before = factors.closure, factors.reciprocity, factors.largest_error, factors.sky_change
    factors.F.data *= 0.5
    factors.error.data *= 3
    factors.sky[0] += 0.01
    row_sums = factors.F.toarray().sum(axis=1) + factors.sky + factors.back
    assert factors.closure == pytest.approx(np.abs(row_sums - 1).max())
    assert factors.largest_error == pytest.approx(3 * before[2])
    assert factors.sky_change == pytest.approx(np.abs(factors.sky - factors.unprojected_sky).max())
    assert factors.closure > before[0]
    assert factors.reciprocity == pytest.approx(before[1])
