"""Polygons as patches: cut into quads and triangles, merged from triangles, split where they are not planar.

A patch is 4 x 3: a planar, strictly convex quadrilateral, or a triangle that repeats its last vertex.
"""

from collections.abc import Iterator
from itertools import pairwise

import mapbox_earcut
import numpy as np

from golden.base.errors import InputError
from golden.scene.adjacency import FLAT, ROUNDING, coplanar, patch_normals, rounded_sine, shared_edges, surface_numbers

__all__ = ["CONVEX", "as_patches", "crosses_itself", "cut_polygon", "is_convex_quad", "ladder", "merge_triangles",
           "split_nonplanar"]

CONVEX = 1e-4
"""Least sine of the exterior angle at each corner of a strictly convex quad."""

STRAIGHT = 1e-6
"""Largest sine of the exterior angle of a vertex on a straight side of a polygon."""

SLIVER = 0.01
"""Height of a half of a quad, over that of the lower half at its other diagonal, up to which it is a sliver."""

SHAPES = 64
"""Steps of skewness between a right angle and a straight one."""


def as_patches(triangles: np.ndarray) -> np.ndarray:
    """T x 3 x 3 triangles as T x 4 x 3 patches."""
    return np.asarray(triangles, dtype=np.float64)[:, [0, 1, 2, 2]]


def _corner_sines(quads: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sines of the exterior angles about the quad's normal (N x 4), and the bound of their rounding error (N)."""
    normals, _ = patch_normals(quads)
    ahead = np.roll(quads, -1, axis=1) - quads
    lengths = np.linalg.norm(ahead, axis=2)
    behind, behind_lengths = np.roll(ahead, 1, axis=1), np.roll(lengths, 1, axis=1)
    winding = np.einsum("nij,nj->ni", np.cross(behind, ahead), normals)
    product = lengths * behind_lengths
    sines = np.divide(winding, product, out=np.zeros_like(winding), where=product > 0)
    return sines, rounded_sine(np.abs(quads).max(axis=(1, 2)), lengths.min(axis=1))


def _halves(quads: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """For each diagonal the doubled area vectors of the triangles beside it (N x 3) and the lower one's height (N)."""
    for a, b, c, d in ((0, 1, 2, 3), (1, 2, 3, 0)):
        diagonal = quads[:, c] - quads[:, a]
        one = np.cross(quads[:, b] - quads[:, a], diagonal)
        other = np.cross(diagonal, quads[:, d] - quads[:, a])
        length = np.linalg.norm(diagonal, axis=1)
        lower = np.minimum(np.linalg.norm(one, axis=1), np.linalg.norm(other, axis=1))
        yield one, other, np.divide(lower, length, out=np.zeros_like(length), where=length > 0)


def _folds(quads: np.ndarray) -> np.ndarray:
    """N bool: the two triangles on either side of a diagonal are not coplanar, for either diagonal."""
    folded = np.zeros(len(quads), dtype=bool)
    reach = np.abs(quads).max(axis=(1, 2))
    for one, other, height in _halves(quads):
        product = np.linalg.norm(one, axis=1) * np.linalg.norm(other, axis=1)
        sine = np.linalg.norm(np.cross(one, other), axis=1)
        sine = np.divide(sine, product, out=np.ones_like(sine), where=product > 0)
        folded |= sine > FLAT + rounded_sine(reach, height)
    return folded


def _heights(quads: np.ndarray) -> np.ndarray:
    """N x 2: above each diagonal the height of the lower triangle, below 0 if the other's orientation is opposite."""
    return np.stack([np.copysign(height, np.einsum("ij,ij->i", one, other)) for one, other, height in _halves(quads)],
                    axis=1)


def crosses_itself(quads: np.ndarray) -> np.ndarray:
    """N bool: the N x 4 x 3 quads are planar, and sides cross by more than the error of rounding to float32."""
    reach = np.abs(quads).max(axis=(1, 2))
    return (_heights(quads) < -ROUNDING * reach[:, None]).all(axis=1) & ~_folds(quads)


def is_convex_quad(quads: np.ndarray) -> np.ndarray:
    """N bool: the N x 4 x 3 quads are planar and strictly convex.

    Planar: across both diagonals the sine between the halves is at most `golden.scene.adjacency.FLAT` (1e-5) plus the
    error of rounding the coordinates to float32 (2^-21 of the largest coordinate over the height of the narrower half,
    at most 1e-2). Strictly convex: the sine of every exterior angle exceeds `CONVEX` (1e-4) plus the same
    error over the shortest side.
    """
    sines, rounding = _corner_sines(quads)
    return (sines.min(axis=1, initial=1) > CONVEX + rounding) & ~_folds(quads)


def split_nonplanar(quads: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Cuts quads that are no patches into two triangles each.

    Parameters
    ----------
    quads
        N x 4 x 3; triangles (last vertex repeated) pass unchanged. A quad that `is_convex_quad` accepts passes too.
        Others are cut along the diagonal that gives two triangles of the same orientation, neither of them a sliver,
        as at a straight corner; the shorter one if both do.

    Returns
    -------
    patches
        M x 4 x 3, in the order of the quads.
    parent
        M int64, the quad of each patch.
    """
    quads = np.asarray(quads, dtype=np.float64)
    split = ~is_convex_quad(quads) & (quads[:, 3] != quads[:, 2]).any(axis=1)
    parent = np.repeat(np.arange(len(quads)), 1 + split)
    patches = quads[parent]
    first = np.flatnonzero(split) + np.arange(np.count_nonzero(split))
    bad = quads[split]
    lengths = np.linalg.norm(bad[:, [2, 3]] - bad[:, [0, 1]], axis=2)
    heights = _heights(bad)
    order = np.sign(heights) * (1 + (np.abs(heights) > SLIVER * np.abs(heights).max(axis=1, keepdims=True)))
    from_one = np.where(order[:, 0] == order[:, 1], lengths[:, 1] < lengths[:, 0], order[:, 1] > order[:, 0])
    turned = np.where(from_one[:, None, None], np.roll(bad, -1, axis=1), bad)
    patches[first] = turned[:, [0, 1, 2, 2]]
    patches[first + 1] = turned[:, [0, 2, 3, 3]]
    return patches, parent


def merge_triangles(triangles: np.ndarray, groups: np.ndarray, *, alike=None) -> tuple[
        np.ndarray, np.ndarray, np.ndarray]:
    """Merges pairs of triangles that form a quad, which a file format had cut.

    Two triangles merge if they share an edge (equal coordinates, opposite directions), are of one group and form a
    planar, strictly convex quad (`is_convex_quad`). If most pairs that can merge are consecutive halves of a
    quad, (a, b, c), (a, c, d) or (a, b, c), (c, d, a), such pairs merge first. Then the pair closest to a rectangle
    merges, which restores the grid from which an array of triangles was cut.

    Parameters
    ----------
    triangles
        T x 3 x 3.
    groups
        T integers; only triangles of the same group (a material, say) merge.
    alike
        Of K left triangles, K right ones and K x 4 x 3 quads, which pairs may merge, K bool. Default: all.

    Returns
    -------
    patches
        N x 4 x 3, in the order of each one's first triangle; a quad starts at that triangle's first vertex.
    surface
        N int64, equal for patches of one group that are connected by edges and coplanar.
    parent
        N int64, the first triangle of each patch.
    """
    single = as_patches(triangles)
    surface = surface_numbers(single, groups)
    pairs = shared_edges(single, groups)
    pairs = pairs[coplanar(single, pairs)]
    # The left triangle with the far corner of the right one inserted after the start of their edge.
    edge, far = np.minimum(pairs.left_edge, 2), (np.minimum(pairs.right_edge, 2) + 2) % 3
    edge = np.where(pairs.left_edge == 3, 2, edge)
    far = np.where(pairs.right_edge == 3, 1, far)
    slots = np.array([[0, 3, 1, 2], [0, 1, 3, 2], [0, 1, 2, 3]])[edge]
    corners = np.concatenate((single[pairs.left, :3], single[pairs.right, far][:, None]), axis=1)
    quads = np.take_along_axis(corners, slots[:, :, None], axis=1)
    joins = is_convex_quad(quads)
    if alike is not None:
        joins &= alike(pairs.left, pairs.right, quads)
    fine = np.flatnonzero(joins)
    quads, pairs = quads[fine], pairs[fine]
    ahead = np.roll(quads, -1, axis=1) - quads
    ahead /= np.linalg.norm(ahead, axis=2, keepdims=True)
    skew = np.abs(np.einsum("nij,nij->ni", ahead, np.roll(ahead, 1, axis=1))).max(axis=1, initial=0)
    is_fan = (pairs.right == pairs.left + 1) & (pairs.left_edge == 3) & (pairs.right_edge != 1)
    able = len(np.union1d(pairs.left, pairs.right))
    is_fan &= 2 * np.count_nonzero(is_fan) > able / 2
    # Coarse steps of skewness: rounding must not mix two pairings of a grid.
    order = np.lexsort((pairs.left, np.where(is_fan, 0, 1 + np.floor(SHAPES * skew))))
    left, right, quads = pairs.left[order], pairs.right[order], quads[order]
    taken = bytearray(len(single))
    chosen = []
    for row, (one, other) in enumerate(zip(left.tolist(), right.tolist(), strict=True)):
        if not taken[one] and not taken[other]:
            taken[one] = taken[other] = 1
            chosen.append(row)
    single[left[chosen]] = quads[chosen]
    kept = np.ones(len(single), dtype=bool)
    kept[right[chosen]] = False
    parent = np.flatnonzero(kept)
    return single[parent], surface[parent], parent


def _without_repeats(points: np.ndarray) -> np.ndarray:
    return points[(points != np.roll(points, 1, axis=0)).any(axis=1)]


def _flat(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The polygon seen along its main axis, counter-clockwise (n x 2), and its area vector."""
    local = points - points[0]
    vector = 0.5 * np.cross(local, np.roll(local, -1, axis=0)).sum(axis=0)
    axis = int(np.abs(vector).argmax())
    plane = points[:, [(axis + 1) % 3, (axis + 2) % 3]]
    return (plane if vector[axis] > 0 else plane[:, ::-1]), vector


def _exterior_angles(plane: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sine and cosine of the exterior angle at every vertex."""
    ahead = np.roll(plane, -1, axis=0) - plane
    ahead = ahead / np.linalg.norm(ahead, axis=1, keepdims=True)
    behind = np.roll(ahead, 1, axis=0)
    return behind[:, 0] * ahead[:, 1] - behind[:, 1] * ahead[:, 0], (behind * ahead).sum(axis=1)


def ladder(count: int) -> np.ndarray:
    """Quads across a convex polygon of ``count`` corners, from one side to the other, with a triangle at the end."""
    steps = np.arange((count - 1) // 2)
    rungs = np.stack((steps, steps + 1, count - 2 - steps, count - 1 - steps), axis=1)
    if count % 2:
        rungs[-1] = rungs[-1, [3, 0, 1, 2]]
    return rungs


def _twice_area(plane: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    a, b, c = (plane[triangles[:, k]] for k in range(3))
    return (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]


def _with_side_points(triangles: list[tuple[int, int, int]], sides: dict[tuple[int, int], list[int]]) -> list:
    """Cuts triangles so that the points on their ``sides`` become corners."""
    done, waiting = [], list(triangles)
    while waiting:
        a, b, c = waiting.pop()
        for start, end, apex in ((a, b, c), (b, c, a), (c, a, b)):
            if (start, end) in sides:
                chain = [start, *sides[start, end], end]
                waiting.extend((apex, one, other) for one, other in pairwise(chain))
                break
        else:
            done.append((a, b, c))
    return done


def cut_polygon(points: np.ndarray) -> np.ndarray:
    """Cuts a planar simple polygon into patches.

    Parameters
    ----------
    points
        n x 3 vertices, counter-clockwise from the front; convex or concave. Vertices on a straight side are kept,
        so that neighbours share them; repeated ones are dropped.

    Returns
    -------
    ndarray
        K x 4 x 3 convex quads and triangles with the polygon's orientation; quads are planar and strictly convex
        (`is_convex_quad`). A polygon that is not quite planar is cut as its projection along its main axis.

    Raises
    ------
    InputError
        The polygon has no area, or crosses itself.
    """
    points = _without_repeats(np.asarray(points, dtype=np.float64).reshape(-1, 3))
    if len(points) < 3:
        raise InputError(f"polygon: it has {len(points)} different vertices, three at least are needed")
    plane, vector = _flat(points)
    extent = np.ptp(points, axis=0).max()
    if not np.abs(vector).max() > 1e-14 * extent * extent:
        raise InputError("polygon: it has no area")
    if len(points) == 3:
        return points[None, [0, 1, 2, 2]]
    # A bridge to a hole passes two vertices twice, but a hole has three.
    if len(_without_repeats(plane)) != len(plane) or 2 * len(np.unique(points, axis=0)) < len(points):
        raise InputError("polygon: it crosses itself")
    sines, cosines = _exterior_angles(plane)
    if sines.min() > CONVEX and np.arctan2(sines, cosines).sum() < 3 * np.pi:
        patches, _ = split_nonplanar(points[ladder(len(points))])
        return patches
    corners = np.flatnonzero((np.abs(sines) > STRAIGHT) | (cosines < 0))
    ends = np.array([len(corners)], dtype=np.uint32)
    triangles = corners[mapbox_earcut.triangulate_float64(plane[corners], ends).reshape(-1, 3)]
    doubled = _twice_area(plane, triangles)
    triangles[doubled < 0] = triangles[doubled < 0][:, ::-1]
    outline = plane[corners] - plane[corners[0]]
    turned = np.roll(outline, -1, axis=0)
    whole = (outline[:, 0] * turned[:, 1] - outline[:, 1] * turned[:, 0]).sum()
    if not abs(np.abs(doubled).sum() - whole) <= 1e-9 * np.abs(whole):
        raise InputError("polygon: it crosses itself")
    triangles = triangles[doubled != 0]
    sides = {}
    for start, end in zip(corners, np.roll(corners, -1), strict=True):
        between = np.arange(start + 1, end if end > start else end + len(points)) % len(points)
        if len(between):
            sides[int(start), int(end)] = between.tolist()
    triangles = np.array(_with_side_points([tuple(row) for row in triangles.tolist()], sides))
    patches, _, _ = merge_triangles(points[triangles], np.zeros(len(triangles), dtype=int))
    return patches
