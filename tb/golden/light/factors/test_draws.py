"""Compiled and on arrays, rays and segments have the same bits."""

import numpy as np
import pytest

from golden.light.factors import draws, points
from golden.light.factors.draws import hemisphere_rays, segments_by_direction, segments_by_points
from golden.light.factors.sides import Sides
from golden.light.sampling import mix
from golden.scene.builtin import builtin_scene
from tb.golden.light.factors.on_arrays import on_arrays

COUNT = 4000


@pytest.fixture(scope="module")
def sides():
    """Triangles and quadrilaterals, fronts and backs."""
    return Sides(builtin_scene("room1627"))


@pytest.mark.parametrize("draw", [hemisphere_rays, segments_by_direction, segments_by_points])
def test_both_have_the_same_bits(draw, sides, monkeypatch):
    pairs = np.random.default_rng(1).integers(len(sides), size=(1 if draw is hemisphere_rays else 2, COUNT))
    found = []
    for modules in ((), (points, draws)):
        on_arrays(monkeypatch, *modules)
        found.append(draw(sides, *pairs, mix(5, pairs[0]), 3 * np.arange(COUNT)))
    for compiled, plain in zip(*found, strict=True):
        assert np.ptp(compiled) > 0
        assert compiled.tobytes() == plain.tobytes()
