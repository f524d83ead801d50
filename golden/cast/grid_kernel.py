"""The traversal of `golden.cast.grid.Grid` as a compiled function, ray by ray."""

from typing import NamedTuple

import numpy as np

from golden.base.compiled import compiled
from golden.cast.patch_kernel import dominant_axis, meet, position

__all__ = ["GridHits", "GridRays", "GridScene", "cast"]

# A component of a direction this much smaller than the largest one moves no ray by a cell's margin.
STILL = 2.0**-60


class GridRays(NamedTuple):
    """R rays, see `golden.cast.rays.Rays`."""

    origin: np.ndarray
    direction: np.ndarray
    source: np.ndarray
    target: np.ndarray
    tmax: np.ndarray


class GridScene(NamedTuple):
    """Patches in cells.

    Parameters
    ----------
    nearest
        Least distance of a hit in scene units.
    base, margin, size, shape
        The cells, see `golden.scene.cells.Cells`.
    table, listed
        Per cell, with a border around the grid, its first entry in ``listed`` and their number, -1 in the border; the
        patches' numbers.
    vertices, is_triangle, surface
        The scene's patches.
    """

    nearest: float
    base: np.ndarray
    margin: float
    size: float
    shape: np.ndarray
    table: np.ndarray
    listed: np.ndarray
    vertices: np.ndarray
    is_triangle: np.ndarray
    surface: np.ndarray


class GridHits(NamedTuple):
    """Hits of R rays, see `golden.cast.rays.Hits`."""

    patch: np.ndarray
    t: np.ndarray
    u: np.ndarray
    v: np.ndarray
    tests: np.ndarray
    steps: np.ndarray


@compiled
def cast(scene, rays, any_hit, hits):
    """Cast rays.

    Parameters
    ----------
    scene, rays
        A `GridScene`, and `GridRays`.
    any_hit
        The first cell with a hit ends a ray.
    hits
        `GridHits`, which are written.
    """
    origin, direction, source, target, tmax = rays
    nearest, base, margin, size, shape, table, listed, vertices, is_triangle, surface = scene
    patch_of, t_of, u_of, v_of, tests_of, steps_of = hits
    strides = ((shape[1] + 2) * (shape[2] + 2), shape[2] + 2, 1)
    p, inverse, moves, stride = np.empty(3), np.empty(3), np.empty(3, dtype=np.bool_), np.empty(3, dtype=np.int64)
    cross, plane, between = np.empty(3), np.empty(3), np.empty(3)
    # The last ray that tested each patch: a patch of several cells gives the same in each.
    tested = np.full(len(vertices), -1)
    for ray in range(len(origin)):
        largest = max(abs(direction[ray, 0]), abs(direction[ray, 1]), abs(direction[ray, 2]))
        # Enter the grid.
        entry, leave = 0.0, np.inf
        for axis in range(3):
            d = direction[ray, axis]
            p[axis] = (origin[ray, axis] - base[axis]) + margin
            moves[axis] = abs(d) > STILL * largest
            extent = shape[axis] * size
            if moves[axis]:
                inverse[axis] = 1 / d
                low, high = (0 - p[axis]) * inverse[axis], (extent - p[axis]) * inverse[axis]
                entry, leave = max(entry, min(low, high)), min(leave, max(low, high))
            elif not 0 <= p[axis] <= extent:
                entry = np.inf
        best, found, tests, steps = tmax[ray], -1, 0, 0
        if entry <= leave and entry < best:
            kz = dominant_axis(direction[ray, 0], direction[ray, 1], direction[ray, 2])
            kx, ky = (kz + 1) % 3, (kz + 2) % 3
            ox, oy, oz = origin[ray, kx], origin[ray, ky], origin[ray, kz]
            sx, sy = direction[ray, kx] / direction[ray, kz], direction[ray, ky] / direction[ray, kz]
            scale = 1 / direction[ray, kz]
            tmin = nearest / np.sqrt(direction[ray, 0] * direction[ray, 0] + direction[ray, 1] * direction[ray, 1]
                                     + direction[ray, 2] * direction[ray, 2])
            cell = 0
            for axis in range(3):
                d = direction[ray, axis]
                index = min(max(int((p[axis] + d * entry) / size), 0), shape[axis] - 1)
                cell += (index + 1) * strides[axis]
                cross[axis], plane[axis], between[axis], stride[axis] = np.inf, 0.0, 0.0, 0
                if moves[axis]:
                    forward = d > 0
                    plane[axis] = (index + (1 if forward else 0)) * size
                    between[axis] = size if forward else -size
                    stride[axis] = strides[axis] if forward else -strides[axis]
                    cross[axis] = (plane[axis] - p[axis]) * inverse[axis]
            # Traverse it.
            c0, c1, c2 = cross[0], cross[1], cross[2]
            count = table[cell, 1]
            while count >= 0:
                leave = min(c0, c1, c2)
                steps += 1
                tests += count
                first = table[cell, 0]
                for place in range(first, first + count):
                    patch = listed[place]
                    if tested[patch] == ray or surface[patch] == source[ray] or surface[patch] == target[ray]:
                        continue
                    tested[patch] = ray
                    met, depth = meet(vertices, patch, kx, ky, kz, ox, oy, oz, sx, sy)
                    t = depth * scale
                    if met and t > tmin and (t < best or (t == best and patch < found)):
                        best, found = t, patch
                if best <= leave or (any_hit and found >= 0):
                    break
                if c0 <= leave:
                    cell += stride[0]
                    plane[0] += between[0]
                    c0 = (plane[0] - p[0]) * inverse[0]
                if c1 <= leave:
                    cell += stride[1]
                    plane[1] += between[1]
                    c1 = (plane[1] - p[1]) * inverse[1]
                if c2 <= leave:
                    cell += stride[2]
                    plane[2] += between[2]
                    c2 = (plane[2] - p[2]) * inverse[2]
                count = table[cell, 1]
        u, v = 0.0, 0.0
        if found >= 0:
            u, v = position(vertices, found, is_triangle[found], kx, ky, kz, ox, oy, oz, sx, sy)
        patch_of[ray], t_of[ray], u_of[ray], v_of[ray] = found, best if found >= 0 else np.inf, u, v
        tests_of[ray], steps_of[ray] = tests, steps
