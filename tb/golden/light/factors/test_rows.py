from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from benchmarks.closed_forms import c_11
from golden.base.errors import InputError
from golden.light.factors.compute import compute_view_factors
from golden.light.factors.projection import project
from tb.golden.light.cube import cube
from tb.golden.light.factors.plates import plates
from tb.golden.light.factors.rows import rows_of
from tb.golden.light.scenes import BLACK, rectangle, scene_of


def test_blocks_are_the_rows_whatever_the_others():
    rows = rows_of(plates(), error=2e-2, sky_patches="tregenza", seed=3)
    whole = rows.rows(0, len(rows))
    ends = [0, 1, 3, len(rows)]
    parts = [rows.rows(first, last) for first, last in pairwise(ends)]
    for name in ("column", "hits", "factor", "error", "rays", "sky", "back", "sky_error", "sky_patches",
                 "hidden_error"):
        joined = np.concatenate([getattr(part, name) for part in parts])
        assert joined.tobytes() == getattr(whole, name).tobytes()
    np.testing.assert_array_equal(np.concatenate([np.diff(part.start) for part in parts]), np.diff(whole.start))


def test_every_ray_is_counted():
    rows = rows_of(plates(), error=0.1)
    block = rows.rows(0, len(rows))
    met = np.add.reduceat(block.hits, block.start[:-1])
    # Geometry decides all that the two sides of the plate see.
    np.testing.assert_array_equal(block.sky_error > 0, [True, True, False, False])
    np.testing.assert_allclose((met / rows.rays + block.sky)[:2], 1)
    assert not block.back.any()


def test_backs_of_one_sided_patches_take_rays():
    scene = scene_of(([rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), rectangle((0, 0, 1), (1, 0, 0), (0, 1, 0))], BLACK))
    block = rows_of(scene, error=0.1).rows(0, 1)
    assert not len(block.column)
    assert block.back[0] / 256 + block.sky[0] == 1
    assert block.back[0] == pytest.approx(256 * 0.2, abs=15)


def test_each_large_pair_is_measured_from_one_side():
    rows = rows_of(cube(2), error=1e-2)
    block = rows.rows(0, len(rows))
    row = np.repeat(np.arange(len(rows)), np.diff(block.start))
    measured = ~np.isnan(block.factor)
    pairs = np.sort(np.stack([row, block.column], axis=1)[measured], axis=1)
    # Each patch faces the 20 patches of the other five faces, and all these factors are above half the error.
    assert len(np.unique(pairs, axis=0)) == len(pairs) == 24 * 20 // 2
    assert (block.error[measured] == 0).sum() > 0
    assert (np.add.reduceat(measured, block.start[:-1]) > 0).all()


def test_the_smaller_patch_measures():
    scene = scene_of(([rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), rectangle((0, 0, 1), (0, 2, 0), (2, 0, 0))], BLACK))
    block = rows_of(scene).rows(0, 2)
    np.testing.assert_array_equal(np.isnan(block.factor), [False, True])


def test_patches_of_the_sky_sum_to_the_sky():
    rows = rows_of(plates(), error=2e-2, sky_patches="reinhart")
    found = compute_view_factors(rows)
    assert found.sky_patches.shape == (4, 578)
    np.testing.assert_allclose(found.sky_patches.sum(axis=1), found.sky, rtol=1e-14)
    # Between two squares the sky is at the sides.
    zenith = found.sky_patches[:, [577]].toarray().ravel()
    assert zenith.max() == 0
    assert found.sky.min() > 0.1
    assert found.settings["sky_patches"] == "reinhart"


@pytest.mark.parametrize(("up", "along"), [((0, 0, 1), (0, 1, 0)), ((0, 2, 0), (0, 0, -1))])
def test_a_square_under_a_bare_sky_sees_each_patch_by_its_height(up, along):
    scene = scene_of(([rectangle((0, 0, 0), (1, 0, 0), along)], BLACK), up=up)
    factors = compute_view_factors(rows_of(scene, error=1e-3, sky_patches="tregenza"))
    assert factors.settings["zenith"] == list(up)
    found = factors.sky_patches.toarray()[0]
    sine = np.sin(np.radians(12)) ** 2
    assert found[0] == 0
    np.testing.assert_allclose(found[1:31].reshape(5, 6).sum(axis=1), sine / 5, rtol=0.2)
    assert found[1:31].sum() == pytest.approx(sine, rel=0.05)
    assert found[145] == pytest.approx(np.sin(np.radians(6)) ** 2, rel=0.1)
    assert found.sum() == 1


def test_shares_of_patches_of_the_sky_have_errors_that_bound_them_as_requested():
    """A level square sees a patch of the sky between two heights by the difference of their sines' squares."""
    scene = scene_of(([rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0))], BLACK))
    heights = np.radians(np.append(np.arange(0, 85, 12), 90))
    exact = np.repeat(np.diff(np.sin(heights)**2) / [30, 30, 24, 24, 18, 12, 6, 1], [30, 30, 24, 24, 18, 12, 6, 1])
    for sky_error in (4e-3, 1e-3):
        found = compute_view_factors(rows_of(scene, error=1e-2, sky_error=sky_error, sky_patches="tregenza"))
        share, error = (values.toarray()[0, 1:] for values in (found.sky_patches, found.sky_patches_error))
        assert 0.5 * sky_error < 2 * error.max() <= sky_error
        assert np.mean(np.abs(share - exact) <= 2 * error) > 0.95
        assert not len(found.sky_missed)
    fewer = compute_view_factors(rows_of(scene, error=1e-2, sky_patches="tregenza"))
    missed = replace(fewer, settings=fewer.settings | {"sky_error": 1e-6})
    assert missed.sky_error.max() == 0
    assert missed.sky_missed.tolist() == [0]


def test_the_sky_of_a_canyon_is_within_its_error():
    """Opposed squares: the sky is what the other one leaves."""
    scene = scene_of(([rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), rectangle((0, 0, 1), (0, 1, 0), (1, 0, 0))], BLACK,
                      {"two_sided": True}), ([rectangle((0.3, 0, 0.5), (0.1, 0, 0), (0, 1, 0))], BLACK))
    exact = compute_view_factors(rows_of(scene, error=5e-2, sky_error=1e-3, seed=99))
    within = []
    for seed in range(6):
        found = compute_view_factors(rows_of(scene, error=2e-2, seed=seed))
        assert found.largest_sky_error <= 2e-2
        within.append(np.abs(found.sky - exact.sky) <= 2 * np.hypot(found.sky_error, exact.sky_error))
    assert np.mean(within) >= 0.8


def test_the_sky_is_what_exact_factors_leave():
    """No rays are spent on it, whatever error is requested."""
    low, high = rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), rectangle((0, 0, 0.5), (0, 1, 0), (1, 0, 0))
    rows = rows_of(scene_of(([low, high], BLACK)), error=1e-2, sky_error=1e-6)
    found = compute_view_factors(rows)
    assert found.F[0, 1] == pytest.approx(c_11(2, 2), abs=1e-7)
    np.testing.assert_allclose(found.sky, 1 - found.F.sum(axis=1), atol=1e-12)
    assert found.largest_sky_error == 0
    assert not len(found.sky_missed)


def test_a_black_back_leaves_the_sky_to_rays():
    """A back that no ray may have met takes a share of the rest."""
    scene = scene_of(([rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), rectangle((0, 0, 9), (0.1, 0, 0), (0, 0.1, 0))],
                      BLACK))
    block = rows_of(scene, error=0.1).rows(0, 1)
    assert not block.back.any()
    assert block.sky_error[0] > 0


def test_rays_refute_a_sky_that_overlapping_patches_leave():
    low, high = rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), rectangle((0, 0, 0.5), (0, 1, 0), (1, 0, 0))
    block = rows_of(scene_of(([low, low, high], BLACK)), error=0.01).rows(2, 3)
    assert block.sky[0] == pytest.approx(1 - c_11(2, 2), abs=0.05)
    assert block.sky_error[0] > 0


def test_rows_that_miss_the_requested_error_are_named(monkeypatch):
    monkeypatch.setattr("golden.light.factors.visibility._MOST", 64)
    monkeypatch.setattr("golden.light.factors.rows._MOST_SKY_RAYS", 256)
    found = compute_view_factors(rows_of(plates(), error=1e-2, sky_error=1e-2))
    assert found.largest_error > 1e-2
    assert {0, 1} <= set(found.missed.tolist())
    assert found.sky_missed.tolist() == np.flatnonzero(2 * found.sky_error > 1e-2).tolist() != []
    fine = compute_view_factors(rows_of(cube(1), error=1e-2))
    assert not len(fine.missed)
    assert not len(fine.sky_missed)


def test_a_row_that_nothing_closes_is_measured_again():
    rows = rows_of(cube(2), error=2e-2)
    block = rows.rows(0, len(rows))
    # Its estimates are far too low.
    own = np.arange(len(block.column)) < block.start[1]
    wrong = replace(block, factor=np.where(own, 0.8 * block.factor, block.factor))
    assert rows.join([wrong[:1], wrong[1:]]).closure <= 1e-9


def test_no_row_is_measured_twice_to_the_same_error(monkeypatch):
    """A row that nothing closes ends the search."""
    def never_closes(estimate, **given):
        F, sky, back = project(estimate, **given)
        area = given["area"]
        return F, sky + (np.arange(len(area)) == 1) * 1e-2, back

    monkeypatch.setattr("golden.light.factors.rows.project", never_closes)
    rows, measured = rows_of(plates(), error=0.1), []
    block = rows._block
    monkeypatch.setattr(rows, "_block", lambda first, last, **given: measured.append(
        (first, last, given["limit"])) or block(first, last, **given))
    compute_view_factors(rows)
    assert [one[:2] for one in measured[1:]] == [(1, 2)] * 3
    # Standard errors are half of the errors.
    assert [limit for *_, limit in measured] == pytest.approx([0.05, 0.05 / 4, 0.05 / 16, 0.05 / 64])


@pytest.mark.parametrize("error", [5e-2, 5e-3])
def test_hidden_pairs_have_the_requested_error(error):
    """Segments are cast until twice the standard error is the error."""
    found = compute_view_factors(rows_of(plates(0.3), error=error))
    assert error / 4 < found.largest_error <= error


def test_rows_of_a_block():
    rows = rows_of(plates(), error=2e-2)
    block = rows.rows(0, len(rows))
    part, alone = block[1:3], rows.rows(1, 3)
    for name, values in vars(part).items():
        np.testing.assert_array_equal(values, getattr(alone, name), err_msg=name)


def test_a_seed_gives_its_own_numbers():
    first, second, again = (rows_of(plates(), error=2e-2, seed=seed).rows(0, 1) for seed in (1, 2, 1))
    assert first.hits.tobytes() == again.hits.tobytes() != second.hits.tobytes()


@pytest.mark.parametrize(("settings", "message"), [
    ({"error": 1e-7}, "view factors: Error must be 1e-6 to 0.1, not 1e-07"),
    ({"error": float("nan")}, "view factors: Error must be 1e-6 to 0.1, not nan"),
    ({"sky_error": 0.2}, "view factors: Sky error must be 1e-6 to 0.1, not 0.2"),
    ({"sky_patches": "perez"}, "view factors: Sky patches must be tregenza or reinhart, not 'perez'"),
    ({"seed": -1}, r"view factors: Seed must be an integer from 0 to 2\^63 - 1, not -1"),
    ({"seed": 0.5}, r"view factors: Seed must be an integer from 0 to 2\^63 - 1, not 0.5"),
])
def test_settings_out_of_range_are_refused(settings, message):
    with pytest.raises(InputError, match=message):
        rows_of(plates(), **settings)


@pytest.mark.parametrize("order", [(0, 1), (1, 0)])
def test_the_hidden_error_of_a_row_is_its_largest(order):
    # Two plates hide both squares together, which geometry does not find; the far one needs a segment or two.
    squares = [rectangle((x, 0, 1), (0, 1, 0), (1, 0, 0)) for x in (0, 2)]
    halves = [rectangle((-1 + 1.5 * k, -1, 0.5), (1.5 + 3 * k, 0, 0), (0, 3, 0)) for k in range(2)]
    # The first row measures the pairs with even columns.
    scene = scene_of(([rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), halves[0], squares[order[0]], halves[1],
                       squares[order[1]]], BLACK))
    block = rows_of(scene, error=0.03).rows(0, 1)
    assert 0.01 < block.hidden_error[0] <= 0.015
