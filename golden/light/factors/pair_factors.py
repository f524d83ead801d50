"""Exchange areas of pairs of polygons without occlusion."""

from functools import cache

import numpy as np

from golden.light.factors.edge_integrals import edge_integrals
from golden.light.factors.pair_kernel import exchange_of_far

__all__ = ["exchange_areas"]

# Sums of the radii over the distance up to which a rule of so many Gauss points along each side is exact to 1e-9 of
# the smaller patch's area.
_FAR = ((0.04, 2), (0.11, 3), (0.2, 4), (0.3, 5))

# Pairs per block, which bounds memory.
_BLOCK = 1 << 11


def exchange_areas(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Area times form factor of each pair's fronts, without occlusion; the same from either patch.

    The part of each patch behind the other one's plane is cut off. Near pairs: the double contour integral
    sum a . b / (2 pi) integral ln r over all pairs of edges a, b. Far pairs: Gauss points on both patches.

    Parameters
    ----------
    first, second
        P x 4 x 3 vertices of convex planar patches, counter-clockwise from the front; a triangle repeats its last one.
        Of a patch that rounding has bent the corners count as in any plane that is as near to them as their own.

    Returns
    -------
    P float64, in squared units of length; the error is below 1e-8 of the smaller patch's area.

    Source: Sparrow, A new and simpler formulation for radiative angle factors (1963).
    """
    total = np.zeros(len(first))
    for start in range(0, len(first), _BLOCK):
        block = slice(start, start + _BLOCK)
        total[block] = _exchange(np.ascontiguousarray(first[block]), np.ascontiguousarray(second[block]))
    return total


def _exchange(first, second):
    total, kind, over = np.empty(len(first)), np.empty(len(first), dtype=np.int8), np.empty((2, len(first), 4))
    exchange_of_far(first, second, *_rules(), total, kind, over)
    rows = np.flatnonzero(kind == 1)
    total[rows] = _by_contours(first[rows], second[rows])
    rows = np.flatnonzero(kind == 2)
    total[rows] = _by_contours(_cut(first[rows], over[0, rows]), _cut(second[rows], over[1, rows]))
    return np.maximum(total, 0)


@cache
def _rules():
    """Limits, first entries and entries of the rules for `exchange_of_far`."""
    entries = []
    for _, points in _FAR:
        knots, gauss = np.polynomial.legendre.leggauss(points)
        u, v = (grid.ravel() / 2 + 0.5 for grid in np.meshgrid(knots, knots, indexing="ij"))
        entries.append(np.stack([u, v, np.outer(gauss, gauss).ravel() / 4], axis=1))
    begin = np.cumsum([0, *map(len, entries)])
    return np.array([limit for limit, _ in _FAR]), begin, np.concatenate(entries)


def _by_contours(first, second):
    """The double contour integral; ``first`` and ``second`` are P x K x 3 polygons in front of each other."""
    if not len(first):
        return np.zeros(0)
    # In units of the pair's size and from its middle, ln r is of order 1.
    middle = first.mean(axis=1)[:, None]
    size = np.maximum(np.abs(first - middle).max(axis=(1, 2)), np.abs(second - middle).max(axis=(1, 2)))
    first, second = ((patch - middle) / size[:, None, None] for patch in (first, second))
    after_1, after_2 = (np.roll(patch, -1, axis=1) for patch in (first, second))
    product = np.einsum("pai,pbi->pab", after_1 - first, after_2 - second)
    pair, edge_1, edge_2 = np.nonzero(np.abs(product) > 1e-15)
    ends_1 = np.stack([first[pair, edge_1], after_1[pair, edge_1]], axis=1)
    ends_2 = np.stack([second[pair, edge_2], after_2[pair, edge_2]], axis=1)
    lengths = np.linalg.norm(ends_1[:, 1] - ends_1[:, 0], axis=1) * np.linalg.norm(ends_2[:, 1] - ends_2[:, 0], axis=1)
    terms = product[pair, edge_1, edge_2] / lengths * edge_integrals(ends_1, ends_2)
    return np.bincount(pair, terms, len(first)) * size * size / (2 * np.pi)


def _cut(patch, height):
    """The part of each patch at heights above 0, P x 5 x 3 with repeated corners; a patch all below it is a point."""
    # No plane cuts all four edges of a planar quad; of a bent one the two corners that are nearer to it are in it.
    turns = (height * np.roll(height, -1, axis=1) < 0).all(axis=1)
    even = np.abs(height[:, ::2]).sum(axis=1) < np.abs(height[:, 1::2]).sum(axis=1)
    height = np.where(turns[:, None] & ((np.arange(4) % 2 == 0) == even[:, None]), 0.0, height)
    after, after_height = np.roll(patch, -1, axis=1), np.roll(height, -1, axis=1)
    crosses = height * after_height < 0
    share = np.divide(height, height - after_height, out=np.zeros_like(height), where=crosses)
    crossing = patch + share[..., None] * (after - patch)
    corners = np.stack([patch, crossing], axis=2).reshape(len(patch), 8, 3)
    kept = np.stack([height >= 0, crosses], axis=2).reshape(len(patch), 8)
    order = np.argsort(~kept, axis=1, kind="stable")[:, :5]
    count = kept.sum(axis=1)
    order = np.where(np.arange(5) < count[:, None], order, np.take_along_axis(order, count[:, None] - 1, axis=1))
    return np.take_along_axis(corners, order[..., None], axis=1)
