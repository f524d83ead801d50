"""The search for the patches of each cell as a compiled function, patch by patch."""

import numpy as np

from golden.base.compiled import compiled

__all__ = ["patches_of_cells"]


@compiled
def patches_of_cells(vertices, lower, size, shape, margin):
    """The patches within a margin of each cell of a grid.

    Parameters
    ----------
    vertices
        N x 4 x 3 float64, planar and convex.
    lower, size, shape
        The grid: lower corner and side of a cell in float64, cells along x, y and z.
    margin
        Distance in the units of the vertices, float64.

    Returns
    -------
    ``start`` and ``patch``, int64: the patches of cell number c are ``patch[start[c]:start[c + 1]]``, ascending; x runs
    slowest.
    """
    half = 0.5 * size + margin
    cells, patches = np.empty((2, 4 * len(vertices)), dtype=np.int64)
    start = np.zeros(shape[0] * shape[1] * shape[2] + 1, dtype=np.int64)
    found = 0
    first, last = np.empty(3, dtype=np.int64), np.empty(3, dtype=np.int64)
    points, edges = np.empty((4, 3)), np.empty((4, 3))
    for patch in range(len(vertices)):
        corners, within = vertices[patch], True
        for axis in range(3):
            low = min(corners[0, axis], corners[1, axis], corners[2, axis], corners[3, axis])
            high = max(corners[0, axis], corners[1, axis], corners[2, axis], corners[3, axis])
            first[axis] = min(max(int((low - margin - lower[axis]) / size), 0), shape[axis] - 1)
            last[axis] = min(max(int((high + margin - lower[axis]) / size), 0), shape[axis] - 1)
            within &= (first[axis] * size <= low - margin - lower[axis]
                       and high + margin - lower[axis] <= (first[axis] + 1) * size)
        for x in range(first[0], last[0] + 1):
            for y in range(first[1], last[1] + 1):
                for z in range(first[2], last[2] + 1):
                    # A patch within one cell needs no test.
                    if not within and not _touches(corners, lower, size, half, x, y, z, points, edges):
                        continue
                    if found == len(cells):
                        # Number by number: slices are checked, with a message that takes long to compile.
                        more_cells, more_patches = np.empty((2, 2 * found), dtype=np.int64)
                        for pair in range(found):
                            more_cells[pair], more_patches[pair] = cells[pair], patches[pair]
                        cells, patches = more_cells, more_patches
                    cell = (x * shape[1] + y) * shape[2] + z
                    cells[found], patches[found] = cell, patch
                    start[cell + 1] += 1
                    found += 1
    for cell in range(len(start) - 1):
        start[cell + 1] += start[cell]
    # Patches ascend, so they do in each cell.
    position, listed = start.copy(), np.empty(found, dtype=np.int64)
    for pair in range(found):
        listed[position[cells[pair]]] = patches[pair]
        position[cells[pair]] += 1
    return start, listed


@compiled
def _touches(corners, lower, size, half, x, y, z, p, edge):
    """Whether a patch touches a cell; ``p`` and ``edge`` are 4 x 3 for intermediate results."""
    cx, cy, cz = lower[0] + (x + 0.5) * size, lower[1] + (y + 0.5) * size, lower[2] + (z + 0.5) * size
    for corner in range(4):
        p[corner, 0], p[corner, 1], p[corner, 2] = \
            corners[corner, 0] - cx, corners[corner, 1] - cy, corners[corner, 2] - cz
    for axis in range(3):
        if min(p[0, axis], p[1, axis], p[2, axis], p[3, axis]) > half \
                or max(p[0, axis], p[1, axis], p[2, axis], p[3, axis]) < -half:
            return False
    ax, ay, az = p[2, 0] - p[0, 0], p[2, 1] - p[0, 1], p[2, 2] - p[0, 2]
    bx, by, bz = p[3, 0] - p[1, 0], p[3, 1] - p[1, 1], p[3, 2] - p[1, 2]
    if not _overlap(p, ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx, half):
        return False
    for corner in range(4):
        after = (corner + 1) % 4
        for axis in range(3):
            edge[corner, axis] = p[after, axis] - p[corner, axis]
    for corner in range(4):
        ex, ey, ez = edge[corner, 0], edge[corner, 1], edge[corner, 2]
        # A triangle repeats a vertex.
        if ex == 0 and ey == 0 and ez == 0:
            continue
        if not (_overlap(p, 0.0, ez, -ey, half) and _overlap(p, -ez, 0.0, ex, half)
                and _overlap(p, ey, -ex, 0.0, half)):
            return False
    return True


@compiled
def _overlap(p, dx, dy, dz, half):
    """Whether the points' extent along a direction overlaps that of a cube of half side ``half``."""
    a0, a1 = p[0, 0] * dx + p[0, 1] * dy + p[0, 2] * dz, p[1, 0] * dx + p[1, 1] * dy + p[1, 2] * dz
    a2, a3 = p[2, 0] * dx + p[2, 1] * dy + p[2, 2] * dz, p[3, 0] * dx + p[3, 1] * dy + p[3, 2] * dz
    reach = half * (abs(dx) + abs(dy) + abs(dz))
    return min(a0, a1, a2, a3) <= reach and max(a0, a1, a2, a3) >= -reach
