import numpy as np
import pytest

from benchmarks.closed_forms import c_11
from golden.cast.grid import Grid
from golden.light.factors.sides import Sides
from golden.light.factors.sky_division import SkyDivision
from golden.light.factors.sky_rays import SkyRays
from golden.light.sampling import mix
from tb.golden.light.factors.plates import plates
from tb.golden.light.scenes import BLACK, rectangle, scene_of

SQUARES = [rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), rectangle((0, 0, 1), (0, 1, 0), (1, 0, 0))]


def sky_rays(scene, row, *, seed=0, **given):
    row = np.asarray(row)
    return SkyRays(Sides(scene), Grid(scene, 0.5), row, mix(seed, row), **given)


def test_the_sky_of_opposed_squares_within_the_error():
    scene = scene_of((SQUARES, BLACK))
    found = [sky_rays(scene, [0, 1], seed=seed).shares(0, limit=2e-3, most=1 << 20) for seed in range(20)]
    share, error = (np.concatenate(values) for values in zip(*found, strict=True))
    assert error.max() <= 2e-3
    within = np.abs(share - (1 - c_11(1, 1))) <= 2 * error
    assert within.mean() >= 0.85


def test_an_estimate_that_ends_the_search_has_honest_tails():
    """At most 0.3 % beyond three standard errors: of many estimates, those that are too small ended the search."""
    sides = Sides(scene_of((SQUARES, BLACK)))
    rays = SkyRays(sides, Grid(sides.scene, 0.5), np.zeros(6000, dtype=int), mix(1, np.arange(6000)))
    share, error = rays.shares(0, limit=1e-2, most=1 << 20)
    assert (error == 1e-2).all()
    assert np.mean(np.abs(share - (1 - c_11(1, 1))) > 3 * error) <= 3e-3


def test_the_most_rays_end_the_search():
    rays = sky_rays(plates(), [0, 1], division=SkyDivision("tregenza"))
    share, error = rays.shares(0, limit=1e-9, most=64)
    assert (error > 1e-3).all()
    np.testing.assert_array_equal(rays.patches.sum(axis=1), 64 * share)


def test_rows_do_not_depend_on_each_other():
    together, alone = (sky_rays(plates(), rows).shares(0, limit=5e-3, most=4096) for rows in ([0, 1, 2, 3], [2]))
    for whole, part in zip(together, alone, strict=True):
        assert whole[2:3].tobytes() == part.tobytes()


def test_rays_of_before_count():
    rays = sky_rays(plates(), [0, 1])
    rays.add(np.repeat(1, 32), np.arange(32), np.tile((0.0, 0, 1), (32, 1)))
    share, error = rays.shares(64, limit=1, most=64)
    assert share.tolist() == [0, 0.5]
    assert error[0] == pytest.approx(2 / 68)


def test_the_error_of_a_patch_of_the_sky_is_not_that_of_the_whole():
    """All rays leave, half of them through one patch: more are cast, with the bound of rays that all agree."""
    rays = sky_rays(scene_of((SQUARES[:1], BLACK)), [0], division=SkyDivision("tregenza"))
    rays.add(np.zeros(64, dtype=int), np.arange(64), np.tile([(0.0, 0, 1), (1, 0, 0.5)], (32, 1)))
    _, error = rays.shares(64, limit=0.04, most=4096)
    assert 64 < rays.rays[0] < 4096
    assert error == pytest.approx(2 / (rays.rays + 4))


def test_a_side_that_sees_no_sky_has_the_bound_of_its_rays():
    wide = scene_of(([rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0)),
                      rectangle((-1e4, -1e4, 1e-3), (0, 2e4, 0), (2e4, 0, 0))], BLACK))
    share, error = sky_rays(wide, [0]).shares(0, limit=1e-2, most=4096)
    assert share[0] == 0
    assert 7e-3 < error[0] <= 1e-2


def test_more_rays_of_a_side_are_other_ones():
    scene, directions = plates(), []

    class Recording(Grid):
        def any_hit(self, rays):
            directions.append(rays.direction)
            return super().any_hit(rays)

    SkyRays(Sides(scene), Recording(scene, 0.5), np.array([0]), mix(0, np.array([0]))).shares(0, limit=1e-9, most=256)
    assert len(directions) > 1
    assert len(np.unique(np.concatenate(directions), axis=0)) == 256
