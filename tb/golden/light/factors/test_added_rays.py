"""Rays added to a result: what stays exact, what shrinks, what is refused."""

from dataclasses import replace

import numpy as np
import pytest

from golden import view_factors
from golden.base.errors import InputError
from golden.light.factors import interface
from golden.light.factors.added_rays import combined, runs_of
from golden.light.factors.view_factors import ViewFactors
from golden.scene.builtin import builtin_scene
from tb.golden.light.scenes import rectangle

SCENE = builtin_scene("cornell")


@pytest.fixture(scope="module")
def first():
    return view_factors(SCENE, error=0.1, jobs=1)


@pytest.fixture(scope="module")
def more(first):
    return view_factors(SCENE, error=0.04, jobs=1, more=first)


def test_added_rays_reach_the_error_and_keep_closure_and_reciprocity(first, more):
    assert first.largest_error > 0.04 >= more.largest_error
    assert more.closure < 1e-9
    assert more.reciprocity < 1e-9
    assert not len(more.missed)
    # 1 / 0.1^2 is less than a quarter of 1 / 0.04^2: the first added run halves the error, the others give the rest.
    runs = runs_of(more)
    assert runs[:2] == [(0.1, 0), (pytest.approx(0.1 / 3**0.5), 1)]
    assert len({seed for _, seed in runs}) == len(runs)
    assert sum(error**-2 for error, _ in runs) >= 0.04**-2 * (1 - 1e-12)


def test_the_mean_of_two_results_is_weighted_by_the_squares_of_their_errors(first):
    """With errors of 1 to 2 by 4 to 1; of a factor that one has no entry for, its bound counts."""
    second = view_factors(SCENE, error=0.05, seed=9, jobs=1)
    both = combined(first, second, error=0.02)
    np.testing.assert_allclose(both.F.toarray(), 0.2 * first.F.toarray() + 0.8 * second.F.toarray(), atol=1e-15)
    np.testing.assert_allclose(both.sky_error, np.hypot(0.2 * first.sky_error, 0.8 * second.sky_error))
    row, column = both.F.nonzero()

    def errors(one):
        is_entry = np.asarray(one.error.toarray()[row, column])
        has = np.zeros(one.F.shape, dtype=bool)
        has[np.repeat(np.arange(len(one)), np.diff(one.F.indptr)), one.F.indices] = True
        return np.where(has[row, column], is_entry, one.largest_absent / 2)

    np.testing.assert_allclose(both.error.toarray()[row, column],
                               np.hypot(0.2 * errors(first), 0.8 * errors(second)))


def test_a_stored_result_takes_more_rays(first, more, tmp_path):
    first.to_netcdf(tmp_path / "F.nc")
    again = view_factors(SCENE, error=0.04, jobs=1, more=ViewFactors.open(tmp_path / "F.nc"))
    np.testing.assert_array_equal(again.F.toarray(), more.F.toarray())
    assert runs_of(again) == runs_of(more)


def test_a_result_that_is_good_enough_or_cancelled_stays(first):
    assert view_factors(SCENE, error=0.1, jobs=1, more=first) is first
    assert view_factors(SCENE, error=1e-6, jobs=1, more=first, cancel=lambda: True) is first


@pytest.mark.parametrize(("changed", "message"), [
    (lambda first: replace(first, error=None), "More must be view factors with errors"),
    (lambda first: first.by_surface(), "More must be view factors of the same patches"),
    (lambda first: replace(first, settings=first.settings | {"unit": "mm"}), "of the same unit, not of 'mm'")])
def test_what_is_of_something_else_is_refused(first, changed, message):
    with pytest.raises(InputError, match=message) as caught:
        view_factors(SCENE, error=0.04, jobs=1, more=changed(first))
    assert caught.value.parameter == "more"


FACING = np.array([rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), rectangle((0, 0, 1), (0, 1, 0), (1, 0, 0)),
                   rectangle((0.3, 0.3, 0.5), (0.4, 0, 0), (0, 0.4, 0))])

OCCLUDER_MOVED = np.array([(0, 0, 0), (0, 0, 0), (0.2, 0, 0)])[:, None]


@pytest.mark.parametrize(("change", "name"), [
    ({"geometry": FACING * (1, 1, 3)}, "scene"), ({"geometry": FACING + OCCLUDER_MOVED}, "scene"),
    ({"geometry": FACING[:2]}, "scene"), ({"two_sided": True}, "scene"), ({"unit": "mm"}, "unit"),
    ({"sky_patches": "tregenza"}, "sky_patches")])
@pytest.mark.parametrize("error", [0.1, 0.02])
def test_a_result_of_other_geometry_or_options_is_refused_before_a_ray_is_cast(change, name, error, monkeypatch):
    """However precise it is, and although its areas and normals may be the same."""
    stored = view_factors(FACING, error=0.1, jobs=1)
    monkeypatch.setattr(interface, "compute_view_factors", None)
    with pytest.raises(InputError, match=f"More must be view factors of the same {name}") as caught:
        view_factors(**{"geometry": FACING, "error": error, "jobs": 1, "more": stored} | change)
    assert caught.value.parameter == "more"


@pytest.mark.parametrize("sky_patches", [None, "tregenza"])
def test_added_rays_reach_the_error_of_the_sky_and_of_its_patches(sky_patches):
    coarse, fine = 0.05, 0.01
    stored = view_factors(FACING, error=0.05, sky_error=coarse, sky_patches=sky_patches, jobs=1)
    found = view_factors(FACING, error=0.05, sky_error=fine, sky_patches=sky_patches, jobs=1, more=stored)
    assert fine < max(stored.largest_sky_error, stored.largest_sky_patch_error or 0)
    assert fine >= max(found.largest_sky_error, found.largest_sky_patch_error or 0)
    assert found.settings["sky_error"] == fine
    assert not len(found.sky_missed)


def test_a_patch_of_the_sky_that_one_run_lacks_has_the_error_of_no_hits():
    """2 / (n + 4) of n rays, in each row at most the least error of an entry, whatever the factors' error is."""
    one, two = (view_factors(FACING, error=0.1, sky_error=0.02, sky_patches="reinhart", seed=seed, jobs=1)
                for seed in (0, 1))
    both = combined(one, two, error=0.1)
    row, patch = both.sky_patches.nonzero()
    least = [np.array([part.data.min() for part in (run.sky_patches_error[[number]] for number in range(len(run)))])
             for run in (one, two)]
    absent = [np.asarray(run.sky_patches[row, patch]) == 0 for run in (one, two)]
    assert absent[0].any()
    assert absent[1].any()
    errors = [np.where(missing, bound[row], np.asarray(run.sky_patches_error[row, patch]))
              for run, missing, bound in zip((one, two), absent, least, strict=True)]
    np.testing.assert_allclose(both.sky_patches_error[row, patch], np.hypot(*errors) / 2, rtol=1e-12)
