"""Two unit squares at distance 1 with a plate between them, whose visible factor is known."""

from itertools import pairwise

import numpy as np

from golden.light.analytic import point_to_polygon
from golden.light.closed_forms import c_11
from tb.golden.light.scenes import BLACK, rectangle, scene_of

__all__ = ["plates", "visible_factor"]


def plates(width: float = 0.5):
    """The scene: floor, ceiling, and a two-sided plate over the part 0..``width`` of the floor, halfway up."""
    floor, ceiling = rectangle((0, 0, 0), (1, 0, 0), (0, 1, 0)), rectangle((0, 0, 1), (0, 1, 0), (1, 0, 0))
    return scene_of(([floor, ceiling], BLACK), ([rectangle((0, 0, 0.5), (width, 0, 0), (0, 1, 0))], BLACK,
                                                {"two_sided": True}))


def visible_factor(width: float = 0.5) -> float:
    """From floor to ceiling: C-11 less the factor to the plate's shadow, which is a rectangle from every point."""
    knots, gauss = np.polynomial.legendre.leggauss(24)
    # The shadow's borders cross the ceiling's along these lines, between which the factor is smooth.
    cuts = np.unique(np.clip([0, 2 * width - 1, width, 2 * width, 1], 0, 1))
    total = 0.0
    for low, high in pairwise(cuts):
        for x, weight in zip(low + (high - low) * (knots + 1) / 2, gauss * (high - low) / 2, strict=True):
            left, right = max(0, -x), min(1, 2 * width - x)
            if right > left:
                for y, share in zip((knots + 1) / 2, gauss / 2, strict=True):
                    shadow = rectangle((left, max(0, -y), 1), (0, min(1, 2 - y) - max(0, -y), 0), (right - left, 0, 0))
                    total += weight * share * point_to_polygon([(x, y, 0)], [(0, 0, 1)], [shadow])[0, 0]
    return c_11(1, 1) - total
