"""Compiled and on arrays, rays and segments have the same bits."""

import numpy as np
import pytest

from golden.light.factors import points
from golden.light.factors.draws import hemisphere_rays, segments_by_direction, segments_by_points
from golden.light.factors.sides import Sides
from golden.light.sampling import mix
from golden.scene.builtin import builtin_scene
from tb.golden.light.factors.on_arrays import on_arrays as as_they_are

COUNT = 4000


@pytest.fixture(scope="module")
def sides():
    """Triangles and quadrilaterals, fronts and backs."""
    return Sides(builtin_scene("room1627"))


def on_arrays(draw, sides, *arguments):
    """The same of all rays or segments at once, by the functions of `points` as they are."""
    *pairs, uses, number = arguments
    corners = [np.ascontiguousarray(np.moveaxis(sides.vertices[side], 0, -1)) for side in pairs]
    triangles, axes = [sides.triangle[side] for side in pairs], np.moveaxis(sides.axes[pairs[0]], 0, -1)
    if draw is hemisphere_rays:
        return points.ray(uses, number, corners[0], triangles[0], axes)
    if draw is segments_by_direction:
        return points.segment_by_direction(uses, number, corners[0], triangles[0], axes, corners[1],
                                           sides.normal[pairs[1]].T)
    return points.segment_by_points(uses, number, corners[0], triangles[0], corners[1], triangles[1])


@pytest.mark.parametrize("draw", [hemisphere_rays, segments_by_direction, segments_by_points])
def test_both_have_the_same_bits(draw, sides, monkeypatch):
    pairs = np.random.default_rng(1).integers(len(sides), size=(1 if draw is hemisphere_rays else 2, COUNT))
    arguments = (*pairs, mix(5, pairs[0]), 3 * np.arange(COUNT))
    compiled = np.column_stack(draw(sides, *arguments))
    as_they_are(monkeypatch, points)
    plain = np.stack(on_arrays(draw, sides, *arguments), axis=1)
    assert (np.ptp(compiled, axis=0) > 0).all()
    assert compiled.tobytes() == plain.tobytes()
