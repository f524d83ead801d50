"""The sample points on the ceiling."""

from dataclasses import replace

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.engine.schedule.ceiling_points import ceiling_points
from golden.scene.open import open_scene


def test_sixteen_points_are_the_centres_of_four_by_four_parts_row_by_row():
    scene = open_scene("lobby")
    points, down = ceiling_points(scene)
    lower, upper = scene.bounds
    share = (points - lower) / (upper - lower)
    assert np.allclose(share[:, 0], np.tile([0.125, 0.375, 0.625, 0.875], 4))
    assert np.allclose(share[:, 1], np.repeat([0.125, 0.375, 0.625, 0.875], 4))
    assert np.allclose(share[:, 2], 0.999)
    assert down.tolist() == [0, 0, -1]


def test_the_ceiling_is_where_the_scene_says_up_is():
    points, down = ceiling_points(replace(open_scene("lobby"), up=(0.0, -2.0, 0.0)), 4)
    lower, upper = open_scene("lobby").bounds
    assert np.allclose((points[:, 1] - lower[1]) / (upper[1] - lower[1]), 0.001)
    assert down.tolist() == [0, 1, 0]


def test_other_counts_and_oblique_scenes_are_refused():
    with pytest.raises(InputError, match="Points must be a power of two, not 12"):
        ceiling_points(open_scene("lobby"), 12)
    with pytest.raises(InputError, match="a ceiling needs an up along an axis"):
        ceiling_points(replace(open_scene("lobby"), up=(0.0, 1.0, 1.0)))
