"""Rays of hemispheres and segments between patches, compiled where numba is installed."""

import numpy as np

from golden.base.compiled import is_compiler_active
from golden.light.factors.points import (
    depart,
    join_by_direction,
    join_by_points,
    ray,
    segment_by_direction,
    segment_by_points,
)
from golden.light.factors.sides import Sides

__all__ = ["hemisphere_rays", "segments_by_direction", "segments_by_points"]


def hemisphere_rays(sides: Sides, side: np.ndarray, uses: np.ndarray, number: np.ndarray):
    """Origins and directions, K x 3 float64 each, of rays of the hemispheres of sides.

    Parameters
    ----------
    sides
        The sides.
    side
        K int: the side of each ray.
    uses, number
        K uint64 and K int64, see `golden.light.factors.points.sequence`.
    """
    origin, direction = np.empty((2, len(side), 3))
    if is_compiler_active():
        depart(uses, number, side, sides.vertices, sides.triangle, sides.axes, origin, direction)
    else:
        _write(ray(uses, number, _last(sides.vertices[side]), sides.triangle[side], _last(sides.axes[side])),
               origin, direction)
    return origin, direction


def segments_by_direction(sides: Sides, first: np.ndarray, second: np.ndarray, uses: np.ndarray, number: np.ndarray):
    """Ends of segments along rays of the first sides, K x 3 each, and K weights: 1 if they meet the second ones.

    ``first`` and ``second`` are K sides; for the other parameters see `hemisphere_rays`.
    """
    origin, target = np.empty((2, len(first), 3))
    weight = np.empty(len(first))
    if is_compiler_active():
        join_by_direction(uses, number, first, second, sides.vertices, sides.triangle, sides.axes, origin, target,
                          weight)
    else:
        weight = _write(segment_by_direction(
            uses, number, _last(sides.vertices[first]), sides.triangle[first], _last(sides.axes[first]),
            _last(sides.vertices[second]), sides.normal[second].T), origin, target)
    return origin, target, weight


def segments_by_points(sides: Sides, first: np.ndarray, second: np.ndarray, uses: np.ndarray, number: np.ndarray):
    """Ends of segments between points on both sides, K x 3 each, and K weights cos cos dA dA' / r^2.

    The parameters are those of `segments_by_direction`.
    """
    origin, target = np.empty((2, len(first), 3))
    weight = np.empty(len(first))
    if is_compiler_active():
        join_by_points(uses, number, first, second, sides.vertices, sides.triangle, origin, target, weight)
    else:
        weight = _write(segment_by_points(uses, number, _last(sides.vertices[first]), sides.triangle[first],
                                          _last(sides.vertices[second]), sides.triangle[second]), origin, target)
    return origin, target, weight


def _last(values):
    """K x ... as ... x K."""
    return np.ascontiguousarray(np.moveaxis(values, 0, -1))


def _write(components, *vectors):
    """Fill K x 3 vectors from their components; the component that is left, or None."""
    components = list(components)
    for vector in vectors:
        for axis in range(3):
            vector[:, axis] = components.pop(0)
    return components[0] if components else None
