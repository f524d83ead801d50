import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast.density import Density, Level
from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.fixed_frusta import NaiveFixedFrusta
from golden.light.analytic import point_to_polygon
from golden.light.form_factors import hemisphere_sums, patch_columns
from golden.scene.builtin.shapes import box
from tb.golden.light.scenes import BLACK, scene_of

COARSE = Hemisphere(64, 32)
# The side of a square with 1 % of a cell in the middle of the hemisphere, 1 away.
SIDE = 0.1 * np.pi / 2 / 32
# Around the origin: its rows are closed.
ROOM = box((-2, -2, -2), (2, 2, 2))
PLACEMENTS = 40


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


def placed(generator):
    """A small square that faces the origin, turned around its middle."""
    polar, azimuth, turn = generator.uniform(0.3, 1.2), generator.uniform(0, 2 * np.pi), generator.uniform(0, np.pi)
    middle = np.array([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)])
    a = np.cross(middle, (0, 0, 1)) / np.sin(polar)
    b = np.cross(middle, a)
    # A cell is narrower near the pole: its area is that in the middle times the sine.
    half = SIDE / 2 * np.sqrt(2 * np.sin(polar))
    u, v = half * (np.cos(turn) * a + np.sin(turn) * b), half * (np.cos(turn) * b - np.sin(turn) * a)
    return [middle - u - v, middle + v - u, middle + u + v, middle + u - v]


def test_small_squares_have_their_form_factors():
    generator, errors, rays = np.random.default_rng(5), [], 0
    for _ in range(PLACEMENTS):
        corners = placed(generator)
        scene = scene_of(([corners], BLACK), (ROOM, BLACK))
        sums = hemisphere_sums(NaiveFixedFrusta(scene), COARSE, [(0, 0, 0)], [(0, 0, 1)], -1, columns=len(scene),
                               column_of=patch_columns(scene), density=Density(least=64))
        exact = point_to_polygon(np.zeros((1, 3)), np.array([[0.0, 0, 1]]), scene.vertices[:1])[0, 0]
        errors.append(abs(sums.weights[[0]].toarray()[0, 0] / 2.0**sums.weight_bits / exact - 1))
        rays += int(sums.rays[0])
        assert sums.row_sums[0] == 2**sums.weight_bits == 2**(COARSE.weight_bits + 6)
    assert np.mean(errors) <= 0.05
    assert np.max(errors) <= 0.15
    assert rays <= 1.1 * PLACEMENTS * len(COARSE)


@pytest.mark.parametrize("given", [{"least": 0}, {"least": 5000}, {"least": 1.5}, {"least": 4, "levels": 0}])
def test_what_is_out_of_range_is_named(given):
    with pytest.raises(InputError, match="must be 1 to"):
        Density(**given)
