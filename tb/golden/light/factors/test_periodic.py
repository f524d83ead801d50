"""An endless array of street canyons, whose factors are those of crossed strings."""

from dataclasses import replace

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.cast.grid import Grid
from golden.light.factors.compute import compute_view_factors
from golden.light.factors.periodic import PeriodicRows, tiled
from golden.scene.material import Material
from tb.golden.light.scenes import rectangle, scene_of

GREY = Material(name="grey")
WIDTH, HEIGHT, ROOF, LENGTH = 2.0, 1.0, 1.0, 4.0


def canyon():
    """A road, the walls beside it, and a roof behind the second one: one period of each."""
    y = (0, LENGTH, 0)
    return scene_of(([rectangle((0, 0, 0), (WIDTH, 0, 0), y), rectangle((0, 0, 0), y, (0, 0, HEIGHT)),
                      rectangle((WIDTH, 0, 0), (0, 0, HEIGHT), y),
                      rectangle((WIDTH, 0, HEIGHT), (ROOF, 0, 0), y)], GREY))


def factors(scene, period, *, error):
    tiles = tiled(scene, period)
    return compute_view_factors(PeriodicRows(scene, period, tiles, Grid(tiles), error=error))


def test_an_endless_canyon_has_the_factors_of_crossed_strings():
    """To the requested error and what the ends of the copies leave out: they are more than 17 widths of the canyon
    away, so that a wall or the road sees less than a thousandth of its hemisphere beyond them.
    """
    found = factors(canyon(), (WIDTH + ROOF, LENGTH), error=2e-3)
    diagonal = np.hypot(WIDTH, HEIGHT)
    road_sky, wall_wall = (diagonal - HEIGHT) / WIDTH, (diagonal - WIDTH) / HEIGHT
    expected = np.zeros((4, 4))
    expected[0, 1:3] = (1 - road_sky) / 2
    expected[1:3, 0] = expected[0, 1] * WIDTH / HEIGHT
    expected[1, 2] = expected[2, 1] = wall_wall
    beyond = 3e-3
    np.testing.assert_allclose(found.F.toarray(), expected, atol=beyond)
    np.testing.assert_allclose(found.sky, [road_sky, *[1 - wall_wall - expected[1, 0]] * 2, 1], atol=beyond)
    assert found.closure < 1e-9
    assert found.reciprocity < 1e-9
    assert found.settings["period"] == [WIDTH + ROOF, LENGTH]
    assert found.F.shape == (4, 4)


def test_copies_lie_around_the_scene_which_comes_first():
    scene = canyon()
    tiles = tiled(scene, (3.0, 4.0))
    # Ten heights are four periods of the shorter side.
    assert len(tiles) == 9**2 * len(scene)
    np.testing.assert_array_equal(tiles.vertices[:4], scene.vertices)
    shifts = tiles.vertices[::4, 0] - scene.vertices[0, 0]
    assert np.unique(shifts, axis=0).tolist() == [[3 * i, 4 * j, 0] for i in range(-4, 5) for j in range(-4, 5)]
    assert len(np.unique(tiles.surface)) == len(tiles)
    flat = tiled(replace(scene, vertices=scene.vertices * (1, 1, 0.01)), (30.0, 40.0))
    assert len(flat) == 3**2 * len(scene)


def test_a_scene_with_y_up_repeats_in_its_level_plane():
    turn = np.array([(1, 0, 0), (0, 0, 1), (0, -1, 0)], dtype=float)
    scene = canyon()
    turned = replace(scene, vertices=scene.vertices @ turn.T, up=(0.0, 1.0, 0.0))
    found, expected = (tiled(one, (3.0, 4.0)).vertices for one in (turned, scene))
    np.testing.assert_allclose(found, expected @ turn.T, atol=1e-12)


@pytest.mark.parametrize(("changed", "period", "message"), [
    ({"two_sided": np.ones(4, dtype=bool)}, (3.0, 4.0), "fronts alone"),
    ({}, (2.9, 4.0), "Period must be at least 3,4, the scene's own size, not 2.9,4"),
    ({}, (3.0, np.nan), "Period must be"), ({}, (3.0, np.inf), "Period must be")])
def test_what_cannot_repeat_is_refused(changed, period, message):
    with pytest.raises(InputError, match=message):
        tiled(replace(canyon(), **changed), period)
