"""Adjacency of patches: shared edges, planar surfaces and smooth groups."""

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

__all__ = ["FLAT", "ROUNDING", "SharedEdges", "coplanar", "corner_numbers", "corner_sets", "inside_out",
           "patch_normals", "rounded_sine", "shared_edges", "smooth_numbers", "surface_numbers"]

FLAT = 1e-5
"""Largest sine of the angle between two coplanar patches, for exact coordinates."""

ROUNDING = 2.0 ** -21
"""Uncertainty of a coordinate relative to the largest one: four vertices rounded to float32, with a transform."""

MOST_ROUNDING = 1e-2
"""Upper bound of the sine that is attributed to rounding, also far from the origin."""

MOST_AT_EDGE = 64
"""Most patches at an edge that are paired: their pairs grow with the square of their number."""


class SharedEdges:
    """Pairs of patches with a common edge, in opposite directions.

    ``left``, ``right`` are patch numbers with ``left < right`` (P int64); ``left_edge``, ``right_edge`` are the
    numbers of the edge in each: edge k runs from vertex k to vertex k + 1.
    """

    def __init__(self, left, left_edge, right, right_edge):
        self.left, self.left_edge, self.right, self.right_edge = left, left_edge, right, right_edge

    def __getitem__(self, rows) -> "SharedEdges":
        return SharedEdges(self.left[rows], self.left_edge[rows], self.right[rows], self.right_edge[rows])

    def __len__(self) -> int:
        return len(self.left)


def rounded_sine(reach: np.ndarray, height: np.ndarray) -> np.ndarray:
    """Bound of the error of the sine of an angle by rounding to float32.

    ``reach`` is the largest coordinate, ``height`` the shortest distance that the angle is measured over (it may be
    zero): `ROUNDING` of one over the other, at most `MOST_ROUNDING`.
    """
    sine = np.full(len(height), MOST_ROUNDING)
    np.divide(ROUNDING * reach, height, out=sine, where=height > 0)
    return np.minimum(sine, MOST_ROUNDING)


def corner_numbers(patches: np.ndarray) -> np.ndarray:
    """N x 4 numbers of the corners of N x 4 x 3 patches, equal where all three coordinates are equal."""
    points = np.ascontiguousarray(patches.reshape(-1, 3)) + 0.0  # -0 becomes 0
    order = np.lexsort(points.T)
    fresh = np.ones(len(points), dtype=bool)
    fresh[1:] = (points[order[1:]] != points[order[:-1]]).any(axis=1)
    numbers = np.empty(len(points), dtype=np.int64)
    numbers[order] = np.cumsum(fresh) - 1
    return numbers.reshape(len(patches), -1)


def corner_sets(patches: np.ndarray) -> np.ndarray:
    """N x 4 numbers, equal for N x 4 x 3 patches with the same corners, in any rotation and facing either way."""
    corners = corner_numbers(patches)
    corners[corners[:, 3] == corners[:, 2], 3] = -1  # a triangle repeats any of its corners
    return np.sort(corners, axis=1)


def patch_normals(patches: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Unit normals (N x 3) and areas (N) of N x 4 x 3 patches; the normal of a patch without area is zero."""
    vectors = 0.5 * np.cross(patches[:, 2] - patches[:, 0], patches[:, 3] - patches[:, 1])
    areas = np.linalg.norm(vectors, axis=1)
    return np.divide(vectors, areas[:, None], out=np.zeros_like(vectors), where=areas[:, None] > 0), areas


def shared_edges(patches: np.ndarray, groups: np.ndarray) -> SharedEdges:
    """All pairs of patches of one group that share an edge, bit for bit, in opposite directions.

    ``patches`` is N x 4 x 3, ``groups`` N integers. An edge of more than two patches gives every pair of them, one of
    more than `MOST_AT_EDGE` none.
    """
    corners = corner_numbers(patches)
    start, end = corners.ravel(), np.roll(corners, -1, axis=1).ravel()
    edge = np.flatnonzero(start != end)
    low, high = np.minimum(start, end)[edge], np.maximum(start, end)[edge]
    group = np.repeat(np.asarray(groups), 4)[edge]
    forward = (start < end)[edge]
    order = np.lexsort((edge, group, high, low))
    edge, low, high, group, forward = (value[order] for value in (edge, low, high, group, forward))
    same = (low[1:] == low[:-1]) & (high[1:] == high[:-1]) & (group[1:] == group[:-1])
    # Position of the last edge of each run of equal ones.
    run = np.cumsum(np.concatenate(([0], ~same)))
    last = np.searchsorted(run, run, "right") - 1
    last[last - np.searchsorted(run, run) >= MOST_AT_EDGE] = -1
    found, first, step = [], np.arange(len(edge)), 1
    while len(first := first[first + step <= last[first]]):
        opposite = forward[first] != forward[first + step]
        found.append(np.stack((edge[first[opposite]], edge[first[opposite] + step])))
        step += 1
    pairs = np.sort(np.concatenate(found, axis=1), axis=0) if found else np.empty((2, 0), dtype=np.int64)
    pairs = pairs[:, pairs[0] // 4 != pairs[1] // 4]
    pairs = pairs[:, np.lexsort(pairs[::-1])]
    return SharedEdges(pairs[0] // 4, pairs[0] % 4, pairs[1] // 4, pairs[1] % 4)


def coplanar(patches: np.ndarray, pairs: SharedEdges) -> np.ndarray:
    """P bool: the two patches are in one plane, side by side.

    The sine between their normals is at most `FLAT` plus the error of rounding to float32 (`ROUNDING` of the largest
    coordinate over the height of the narrower patch above the edge, at most `MOST_ROUNDING`).
    """
    normals, areas = patch_normals(patches)
    edge = patches[pairs.left, (pairs.left_edge + 1) % 4] - patches[pairs.left, pairs.left_edge]
    height = np.minimum(areas[pairs.left], areas[pairs.right]) / np.linalg.norm(edge, axis=1)
    reach = np.maximum(*(np.abs(patches).max(axis=(1, 2))[side] for side in (pairs.left, pairs.right)))
    one, other = normals[pairs.left], normals[pairs.right]
    sine = np.linalg.norm(np.cross(one, other), axis=1)
    return (np.einsum("ij,ij->i", one, other) > 0) & (sine <= FLAT + rounded_sine(reach, height))


def _components(count: int, pairs: SharedEdges) -> np.ndarray:
    """Numbers of connected components: equal for patches connected by ``pairs``, from 0 in the order of patches."""
    links = coo_array((np.ones(len(pairs), dtype=bool), (pairs.left, pairs.right)), shape=(count, count))
    labels = connected_components(links, directed=False)[1]
    first, numbers = np.unique(labels, return_index=True)[1], np.empty(count, dtype=np.int64)
    numbers[np.argsort(first)] = np.arange(len(first))
    return numbers[labels]


def inside_out(patches: np.ndarray, groups: np.ndarray) -> np.ndarray:
    """N bool: the patch belongs to a closed body of one group whose fronts face inwards.

    A body is closed if all its edges are shared, in opposite directions, by as many patches on either side.
    """
    pairs = shared_edges(patches, groups)
    body = _components(len(patches), pairs)
    edges = (patches != np.roll(patches, -1, axis=1)).any(axis=2).sum(axis=1)
    shared = np.bincount(body[pairs.left], minlength=len(patches))
    is_closed = 2 * shared == np.bincount(body, edges, minlength=len(patches))
    normals, areas = patch_normals(patches)
    middle = patches[np.unique(body, return_index=True)[1][body], 0]
    heights = np.einsum("ij,ij->i", patches[:, 0] - middle, normals)
    volume = np.bincount(body, heights * areas, minlength=len(patches))
    return (is_closed & (volume < 0))[body]


def surface_numbers(patches: np.ndarray, groups: np.ndarray) -> np.ndarray:
    """N integers, equal for patches of one group that are connected by edges and coplanar."""
    pairs = shared_edges(patches, groups)
    return _components(len(patches), pairs[coplanar(patches, pairs)])


def smooth_numbers(patches: np.ndarray, groups: np.ndarray, *, crease: float) -> np.ndarray:
    """N integers, equal for patches of one group that are connected by edges of less than ``crease`` degrees."""
    pairs = shared_edges(patches, groups)
    normals, _ = patch_normals(patches)
    cosine = np.einsum("ij,ij->i", normals[pairs.left], normals[pairs.right])
    return _components(len(patches), pairs[coplanar(patches, pairs) | (cosine > np.cos(np.radians(crease)))])
