import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast.density import Density, Level
from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.fixed_frusta import NaiveFixedFrusta
from tb.golden.cast.small_squares import check_small_squares


@pytest.mark.parametrize("hemisphere", [Hemisphere(64, 16), Hemisphere(8, 4), Hemisphere(2048, 4)])
def test_fine_weights_sum_to_those_of_the_cells_that_they_divide(hemisphere):
    for level in range(Density(least=1).depth(hemisphere)):
        coarse, fine = (Level(hemisphere, one).row_weights for one in (level, level + 1))
        # Two azimuths of two polar angles, in units of half the size.
        np.testing.assert_array_equal(2 * fine.reshape(-1, 2).sum(axis=1), 2 * coarse)
    np.testing.assert_array_equal(Level(hemisphere, 0).row_weights, hemisphere.polar_weights)


def test_depth_ends_with_the_largest_grid():
    grids = (64, 16), (16, 64), (4096, 4), (4, 4)
    assert [Density(least=1).depth(Hemisphere(*grid)) for grid in grids] == [6, 6, 0, 10]
    assert Density(least=1, levels=2).depth(Hemisphere(64, 16)) == 2


def test_small_squares_have_their_form_factors():
    check_small_squares(NaiveFixedFrusta, 40)


@pytest.mark.parametrize("given", [{"least": 0}, {"least": 5000}, {"least": 1.5}, {"least": 4, "levels": 0}])
def test_what_is_out_of_range_is_named(given):
    with pytest.raises(InputError, match="must be 1 to"):
        Density(**given)
