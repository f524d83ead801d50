"""The patches of each cell by separating axes, a patch and all cells of its box at a time."""

import numpy as np

__all__ = ["touched_cells"]


def touched_cells(vertices, *, lower, size, shape, margin):
    """``start`` and ``patch`` of `golden.scene.cells_kernel.patches_of_cells`."""
    cells, patches = [], []
    for patch, corners in enumerate(vertices):
        first, last = (np.clip(((end - lower) / size).astype(int), 0, np.asarray(shape) - 1)
                       for end in (corners.min(axis=0) - margin, corners.max(axis=0) + margin))
        index = first + np.stack(np.unravel_index(range((last - first + 1).prod()), last - first + 1), axis=1)
        touch = _touches(corners - (lower + (index + 0.5) * size)[:, None], 0.5 * size + margin)
        cells.append(np.ravel_multi_index(index[touch].T, shape))
        patches.append(np.full(len(cells[-1]), patch))
    cells = np.concatenate(cells)
    start = np.concatenate([[0], np.cumsum(np.bincount(cells, minlength=np.prod(shape)))])
    return start, np.concatenate(patches)[np.argsort(cells, kind="stable")]


def _touches(points, half):
    """Whether a patch, relative to each cube of half side ``half``, touches that cube.

    A convex patch and a box are apart if and only if their projections are apart on a box axis, on the patch's
    normal, or on the product of a patch edge and a box axis.
    """
    touch = (points.min(axis=1) <= half).all(axis=1) & (points.max(axis=1) >= -half).all(axis=1)
    touch &= _overlap(points, np.cross(points[:, 2] - points[:, 0], points[:, 3] - points[:, 1]), half)
    edges = np.roll(points, -1, axis=1) - points
    for corner in range(4):
        for axis in np.eye(3):
            touch &= _overlap(points, np.cross(edges[:, corner], axis), half)
    return touch


def _overlap(points, direction, half):
    """Whether the points' extent along a direction overlaps that of a cube of half side ``half``."""
    # Sums in an order of their own: that of a library may depend on the processor.
    along = points[..., 0] * direction[:, None, 0] + points[..., 1] * direction[:, None, 1] \
        + points[..., 2] * direction[:, None, 2]
    size = np.abs(direction)
    reach = half * (size[:, 0] + size[:, 1] + size[:, 2])
    return (along.min(axis=1) <= reach) & (along.max(axis=1) >= -reach)
