"""Exchange areas of pairs of polygons without occlusion."""

import numpy as np

from golden.light.factors.edge_integrals import edge_integrals

__all__ = ["exchange_areas"]

# A corner whose distance from the other patch's plane is below this share of the pair's size counts as in the plane.
_IN_PLANE = 1e-12

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

    Returns
    -------
    P float64, in squared units of length; the error is below 1e-8 of the smaller patch's area.

    Source: Sparrow, A new and simpler formulation for radiative angle factors (1963).
    """
    total = np.zeros(len(first))
    for start in range(0, len(first), _BLOCK):
        block = slice(start, start + _BLOCK)
        total[block] = _exchange(first[block], second[block])
    return total


def _exchange(first, second):
    heights_1, heights_2 = _heights(first, second), _heights(second, first)
    total = np.zeros(len(first))
    facing = (heights_1 > 0).any(axis=1) & (heights_2 > 0).any(axis=1)
    whole = facing & (heights_1 >= 0).all(axis=1) & (heights_2 >= 0).all(axis=1)
    ratio = _nearness(first, second)
    left = whole.copy()
    for limit, points in _FAR:
        rows = np.flatnonzero(left & (ratio <= limit))
        total[rows] = _by_points(first[rows], second[rows], points)
        left[rows] = False
    rows = np.flatnonzero(left)
    total[rows] = _by_contours(first[rows], second[rows])
    rows = np.flatnonzero(facing & ~whole)
    total[rows] = _by_contours(_cut(first[rows], heights_1[rows]), _cut(second[rows], heights_2[rows]))
    return np.maximum(total, 0)


def _heights(patch, other):
    """Distances of a patch's corners from the other one's plane, 0 if by rounding alone."""
    normal = np.cross(other[:, 2] - other[:, 0], other[:, 3] - other[:, 1])
    normal /= np.linalg.norm(normal, axis=1, keepdims=True)
    arms = patch - other.mean(axis=1)[:, None]
    height = np.einsum("pki,pi->pk", arms, normal)
    size = np.abs(arms).max(axis=(1, 2)) + np.abs(other - other[:, :1]).max(axis=(1, 2))
    return np.where(np.abs(height) <= _IN_PLANE * size[:, None], 0.0, height)


def _nearness(first, second):
    """Sum of the radii over the distance of the centres."""
    centres = first.mean(axis=1), second.mean(axis=1)
    radii = sum(np.linalg.norm(patch - centre[:, None], axis=2).max(axis=1)
                for patch, centre in zip((first, second), centres, strict=True))
    distance = np.linalg.norm(centres[0] - centres[1], axis=1)
    return radii / np.maximum(distance, 1e-300)


def _by_points(first, second, points):
    """Sums of cos cos / (pi r^2) over Gauss points on both patches."""
    (from_, area_1), (to, area_2) = (_gauss(patch, points) for patch in (first, second))
    between = to[:, None] - from_[:, :, None]
    square = np.einsum("pqri,pqri->pqr", between, between)
    kernel = (np.einsum("pqri,pqi->pqr", between, area_1) * -np.einsum("pqri,pri->pqr", between, area_2)
              / (np.pi * square * square))
    return kernel.sum(axis=(1, 2))


def _gauss(patch, points):
    """Gauss points of the bilinear coordinates, P x Q x 3, and area vectors of the patch around them, P x Q x 3."""
    knots, gauss = np.polynomial.legendre.leggauss(points)
    u, v = (grid.ravel() / 2 + 0.5 for grid in np.meshgrid(knots, knots, indexing="ij"))
    weights = np.outer(gauss, gauss).ravel() / 4
    corners = np.stack([(1 - u) * (1 - v), u * (1 - v), u * v, (1 - u) * v], axis=1)
    along_u = np.einsum("q,pi->pqi", 1 - v, patch[:, 1] - patch[:, 0]) + np.einsum(
        "q,pi->pqi", v, patch[:, 2] - patch[:, 3])
    along_v = np.einsum("q,pi->pqi", 1 - u, patch[:, 3] - patch[:, 0]) + np.einsum(
        "q,pi->pqi", u, patch[:, 2] - patch[:, 1])
    return np.einsum("qk,pki->pqi", corners, patch), weights[:, None] * np.cross(along_u, along_v)


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
