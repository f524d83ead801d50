"""Rays of hemispheres and segments between patches."""

import numpy as np

from golden.light.factors.points import depart, join_by_direction, join_by_points
from golden.light.factors.sides import Sides

__all__ = ["hemisphere_rays", "segments_by_direction", "segments_by_points"]


def hemisphere_rays(sides: Sides, side: np.ndarray, uses: np.ndarray, number: np.ndarray):
    """Origins and directions, K x 3 float64 each, of rays of the hemispheres of sides.

    Parameters
    ----------
    side
        K int: the side of each ray.
    uses, number
        K uint64 and K int64, see `golden.light.factors.points.sequence`.
    """
    origin, direction = np.empty((2, len(side), 3))
    depart(uses, number, side, sides.vertices, sides.triangle, sides.axes, origin, direction)
    return origin, direction


def segments_by_direction(sides: Sides, first: np.ndarray, second: np.ndarray, uses: np.ndarray, number: np.ndarray):
    """Ends of segments along rays of the first sides, K x 3 each, and K weights: 1 if they meet the second ones.

    ``first`` and ``second`` are K sides; for the other parameters see `hemisphere_rays`.
    """
    origin, target = np.empty((2, len(first), 3))
    weight = np.empty(len(first))
    join_by_direction(uses, number, first, second, sides.vertices, sides.triangle, sides.axes, origin, target,
                      weight)
    return origin, target, weight


def segments_by_points(sides: Sides, first: np.ndarray, second: np.ndarray, uses: np.ndarray, number: np.ndarray):
    """Ends of segments between points on both sides, K x 3 each, and K weights cos cos dA dA' / r^2.

    The parameters are those of `segments_by_direction`.
    """
    origin, target = np.empty((2, len(first), 3))
    weight = np.empty(len(first))
    join_by_points(uses, number, first, second, sides.vertices, sides.triangle, origin, target, weight)
    return origin, target, weight
