"""Small squares around a point in a closed room, and their form factors by hemispheres with finer rays around them."""

import numpy as np

from benchmarks.analytic import point_to_polygon
from golden.cast.density import Density
from golden.cast.hemisphere import Hemisphere
from golden.light.form_factors import hemisphere_sums, patch_columns
from golden.scene.builtin.shapes import box
from tb.golden.light.scenes import BLACK, scene_of

__all__ = ["check_small_squares"]

COARSE = Hemisphere(64, 32)
# The side of a square with 1 % of a cell in the middle of the hemisphere, 1 away.
SIDE = 0.1 * np.pi / 2 / 32
# Around the origin: its rows are closed.
ROOM = box((-2, -2, -2), (2, 2, 2))


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


def check_small_squares(caster, placements: int) -> None:
    """Form factors of one square after the other against the closed form.

    Parameters
    ----------
    caster
        Function from a scene to its caster of frusta.
    placements
        How many squares.

    Raises
    ------
    AssertionError
        The mean error is above 5 %, the worst one above 15 %, a row sum is not 1, or more than a tenth more rays are
        cast than without finer ones.
    """
    generator, errors, rays = np.random.default_rng(5), [], 0
    for _ in range(placements):
        scene = scene_of(([placed(generator)], BLACK), (ROOM, BLACK))
        sums = hemisphere_sums(caster(scene), COARSE, [(0, 0, 0)], [(0, 0, 1)], -1, columns=len(scene),
                               column_of=patch_columns(scene), density=Density(least=64))
        exact = point_to_polygon(np.zeros((1, 3)), np.array([[0.0, 0, 1]]), scene.vertices[:1])[0, 0]
        errors.append(abs(sums.weights[[0]].toarray()[0, 0] / 2.0**sums.weight_bits / exact - 1))
        rays += int(sums.rays[0])
        assert sums.row_sums[0] == 2**sums.weight_bits == 2**(COARSE.weight_bits + 6)
    assert np.mean(errors) <= 0.05
    assert np.max(errors) <= 0.15
    assert rays <= 1.1 * placements * len(COARSE)
