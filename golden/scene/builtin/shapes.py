"""Shapes that the built-in scenes are put together from: N x 4 x 3 arrays of planar patches, fronts outwards.

Neighbouring patches of one shape have the same coordinates, bit for bit, also after `placed`.
"""

import numpy as np

from golden.scene.polygons import ladder

__all__ = ["FACES", "box", "cap", "framed", "frames", "loft", "placed", "rounded", "tube"]

FACES = ("-x", "+x", "-y", "+y", "-z", "+z")
# Corners are numbered by bits: 1 is the upper x, 2 the upper y, 4 the upper z.
_CORNERS = np.array([[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]])


def box(lower, upper, *, omit=()) -> np.ndarray:
    """The faces of an axis-parallel box in the order of `FACES`, but for those named in ``omit``."""
    bounds = np.array([lower, upper], dtype=np.float64)
    corner = np.arange(8)
    points = np.stack([bounds[corner >> axis & 1, axis] for axis in range(3)], axis=-1)
    return points[_CORNERS[[face not in omit for face in FACES]]]


def framed(quad, *, border: float, depth=None) -> np.ndarray:
    """A rectangle with a panel cut into it: four trapezoids around, the sides of a recess, the panel last.

    Parameters
    ----------
    quad
        4 x 3, counter-clockwise from the front. The outer edges stay whole, so that its neighbours share them.
    border
        Distance of the panel from the edges.
    depth
        How far the panel lies behind the rectangle. Default: flush, without sides (5 patches instead of 9).
    """
    quad = np.asarray(quad, dtype=np.float64)
    along = np.roll(quad, -1, axis=0) - quad
    along = along / np.linalg.norm(along, axis=1)[:, None]
    inner = quad + border * (along - np.roll(along, 1, axis=0))
    rings = [quad, inner]
    if depth is not None:
        rings.append(inner - depth * np.cross(along[0], along[1]))
    return np.concatenate([loft(rings), rings[-1][None]])


def loft(rings) -> np.ndarray:
    """The walls between neighbouring closed rings, M x K x 3, counter-clockwise as seen from the last one.

    A ring whose points all coincide is a pole and gives triangles. Where corresponding edges of two rings are parallel
    the quads are planar; others go through `golden.scene.polygons.split_nonplanar`.
    """
    rings = np.asarray(rings, dtype=np.float64)
    lower, upper = rings[:-1], rings[1:]
    quads = np.stack([lower, np.roll(lower, -1, axis=1), np.roll(upper, -1, axis=1), upper], axis=2).reshape(-1, 4, 3)
    quads = np.where((quads[:, 0] == quads[:, 1]).all(axis=1)[:, None, None], quads[:, [1, 2, 3, 3]], quads)
    return np.where((quads[:, 2] == quads[:, 3]).all(axis=1)[:, None, None], quads[:, [0, 1, 2, 2]], quads)


def frames(path) -> tuple[np.ndarray, np.ndarray]:
    """Two unit vectors orthogonal to an open path, M x 3, and to each other, without twist along it: both M x 3."""
    path = np.asarray(path, dtype=np.float64)
    tangent = np.gradient(path, axis=0)
    tangent /= np.linalg.norm(tangent, axis=1)[:, None]
    across = np.empty_like(path)
    previous = np.eye(3)[np.argmin(np.abs(tangent[0]))]
    for row, forward in zip(across, tangent, strict=True):
        previous = previous - forward * (previous @ forward)
        previous = row[:] = previous / np.linalg.norm(previous)
    return across, np.cross(tangent, across)


def tube(path, *, radius: float, sides: int) -> np.ndarray:
    """A round skin of triangles around an open path, M x 3, without end caps; its quads would not be planar."""
    path = np.asarray(path, dtype=np.float64)
    angle = 2 * np.pi * np.arange(sides)[:, None] / sides
    right, up = (vectors[:, None] for vectors in frames(path))
    quads = loft(path[:, None] + radius * (np.cos(angle) * right + np.sin(angle) * up))
    return quads[:, [[0, 1, 2, 2], [0, 2, 3, 3]]].reshape(-1, 4, 3)


def cap(ring) -> np.ndarray:
    """A strictly convex planar ring of K points as a ladder of quads, with a triangle at the end if K is odd."""
    return np.asarray(ring, dtype=np.float64)[ladder(len(ring))]


def rounded(width: float, depth: float, *, radius: float, steps: int, height: float = 0.0) -> np.ndarray:
    """A rectangle around the z axis with round corners, counter-clockwise from above, 4 (steps + 1) x 3.

    Edges of two such rings with equal ``steps`` are parallel where their arcs have a size: their `loft` is planar.
    """
    angle = np.pi / 2 * (np.arange(4)[:, None] + np.arange(steps + 1) / steps).ravel()
    sign = np.repeat([[1, 1], [-1, 1], [-1, -1], [1, -1]], steps + 1, axis=0)
    centre = sign * [width / 2 - radius, depth / 2 - radius]
    ring = centre + radius * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    return np.column_stack([ring, np.full(len(ring), height)])


def placed(patches, *, at=(0.0, 0.0, 0.0), turn: float = 0.0, axis=None, scale=(1.0, 1.0, 1.0)) -> np.ndarray:
    """Patches scaled along the axes, turned by ``turn`` degrees around z, tilted so that z is along ``axis``, moved.

    Equal points stay equal to the bit: a matrix product may round them differently by their index in the array.
    """
    # Rounded so that a quarter turn is exact: what stands against a wall does not reach through it.
    cos, sin = np.round([np.cos(np.radians(turn)), np.sin(np.radians(turn))], 15)
    matrix = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    if axis is not None:
        up = np.asarray(axis, dtype=np.float64) / np.linalg.norm(axis)
        right = np.cross([0.0, 1.0, 0.0] if abs(up[1]) < 0.9 else [1.0, 0.0, 0.0], up)
        right = right / np.linalg.norm(right)
        matrix = np.column_stack([right, np.cross(up, right), up]) @ matrix
    columns = (matrix * np.asarray(scale, dtype=np.float64)).T
    patches = np.asarray(patches, dtype=np.float64)
    return sum((patches[..., k, None] * columns[k] for k in range(3)), np.asarray(at, dtype=np.float64))
