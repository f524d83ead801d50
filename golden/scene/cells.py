"""The uniform grid of cells over a scene, with the patches of each cell."""

import numpy as np

from golden.base.compiled import is_compiler_active
from golden.base.errors import InputError
from golden.scene.scene import Scene

__all__ = ["FINEST", "Cells", "balanced_cell", "check_cell_size", "patches_by_cell"]

# A patch also belongs to cells that it misses by up to this share of the scene's size, so that rounding in a traversal
# misses no patch.
MARGIN_SHARE = 2.0**-30
# Most cells along the longest side: 256^3 start numbers are 128 MiB.
FINEST = 256
# Candidate pairs of patch and cell per block.
BLOCK = 1 << 20


def check_cell_size(cell: float) -> None:
    """A cell size, as a share of the scene box's longest side, is from 1/`FINEST` to 1.

    Raises
    ------
    InputError
        It is out of range.
    """
    if not 1 / FINEST <= cell <= 1:
        raise InputError(f"Cell size must be 1/{FINEST} to 1 of the scene's longest side, not {cell!r}",
                         parameter="cell")


class Cells:
    """Cubic cells from the lower corner of the scene box, each with the ascending numbers of the patches that touch it.

    Parameters
    ----------
    scene
        The patches.
    cell
        Cell size as a share of the scene box's longest side, 1/256 to 1.
    compiled
        See `patches_by_cell`.

    Members
    -------
    size
        Cell size in scene units.
    shape
        Cells along x, y and z.
    base, margin
        Lower corner of the scene box, and its distance along each axis from that of the grid, in scene units. The
        margin is also the largest distance of a patch from a cell that lists it. Positions relative to the base keep
        their precision in a scene far from the origin.
    start, patch
        The patches of cell number c are ``patch[start[c]:start[c + 1]]``; x runs slowest.

    Raises
    ------
    InputError
        Cell size out of range.
    """

    def __init__(self, scene: Scene, cell: float, *, compiled: bool | None = None):
        lower, upper = scene.bounds
        check_cell_size(cell)
        self.margin = MARGIN_SHARE * scene.size
        self.size = cell * scene.size
        # The outermost patches may be exactly on the scene box: the margin keeps them, and rays to them, inside.
        self.base = lower
        self.shape = np.maximum(np.ceil((upper - lower + 2 * self.margin) / self.size).astype(int), 1)
        self.start, self.patch = patches_by_cell(
            scene.vertices - lower, lower=np.full(3, -self.margin), size=self.size, shape=self.shape,
            margin=self.margin, compiled=compiled)

    def __len__(self) -> int:
        return int(self.shape.prod())


def patches_by_cell(vertices: np.ndarray, *, lower: np.ndarray, size: float, shape: np.ndarray, margin: float,
                    compiled: bool | None = None):
    """The patches within a margin of each cell of a grid.

    Parameters
    ----------
    vertices
        N x 4 x 3, planar and convex.
    lower, size, shape
        The grid: lower corner, side of a cell, cells along x, y and z.
    margin
        Distance in the units of the vertices.
    compiled
        Search by numba; the patches do not depend on it. Default: where it is installed and not switched off.

    Returns
    -------
    tuple
        ``start`` and ``patch``: the patches of cell number c are ``patch[start[c]:start[c + 1]]``, ascending; x runs
        slowest.
    """
    lower, shape = np.asarray(lower, dtype=np.float64), np.asarray(shape, dtype=np.int64)
    vertices = np.ascontiguousarray(vertices)
    if is_compiler_active() if compiled is None else compiled:
        from golden.scene.cells_kernel import patches_of_cells

        return patches_of_cells(vertices, lower, float(size), shape, float(margin))
    cells, patches = _touched_cells(vertices, lower, size, shape, margin)
    start = np.concatenate([[0], np.cumsum(np.bincount(cells, minlength=shape.prod()))])
    return start, patches[np.argsort(cells, kind="stable")]


def _touched_cells(vertices, lower, size, shape, margin):
    """Pairs of cell and patch that touch; patches ascend."""
    cells, patches = [], []
    for patch, index in _candidates(vertices, lower, size, shape, margin):
        touch = _touches(vertices[patch] - (lower + (index + 0.5) * size)[:, None], 0.5 * size + margin)
        cells.append(np.ravel_multi_index(index[touch].T, shape))
        patches.append(patch[touch])
    return np.concatenate(cells), np.concatenate(patches)


def _candidates(vertices, lower, size, shape, margin):
    """Blocks of (patch number, cell x y z): every cell that a patch's own box touches."""
    def index(point):
        return np.clip(((point - lower) / size).astype(int), 0, np.asarray(shape) - 1)

    first = index(vertices.min(axis=1) - margin)
    extent = index(vertices.max(axis=1) + margin) - first + 1
    total = np.cumsum(extent.prod(axis=1))
    bounds = np.searchsorted(total, np.arange(BLOCK, total[-1] + BLOCK, BLOCK), side="left") + 1
    begin = 0
    for end in np.unique(np.minimum(bounds, len(vertices))):
        count = extent[begin:end].prod(axis=1)
        patch = np.repeat(np.arange(begin, end), count)
        rank = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
        rank, z = np.divmod(rank, extent[patch, 2])
        x, y = np.divmod(rank, extent[patch, 1])
        yield patch, first[patch] + np.stack([x, y, z], axis=1)
        begin = end


def _touches(points, half):
    """Whether patch k, relative to a cube of half side ``half``, touches that cube, by separating axes.

    A convex patch and a box are apart if and only if their projections are apart on a box axis, on the patch's
    normal, or on the product of a patch edge and a box axis.
    """
    touch = (points.min(axis=1) <= half).all(axis=1) & (points.max(axis=1) >= -half).all(axis=1)
    normal = np.cross(points[:, 2] - points[:, 0], points[:, 3] - points[:, 1])
    touch &= _overlap(points, normal, half)
    some = np.flatnonzero(touch)
    points = points[some]
    edges = np.roll(points, -1, axis=1) - points
    for corner in range(4):
        for axis in range(3):
            touch[some] &= _overlap(points, np.cross(edges[:, corner], np.eye(3)[axis]), half)
    return touch


def _overlap(points, direction, half):
    """Whether the points' extent along a direction overlaps that of a cube of half side ``half``."""
    # Sums in an order of their own: that of a library may depend on the processor.
    along = points[..., 0] * direction[:, None, 0] + points[..., 1] * direction[:, None, 1] \
        + points[..., 2] * direction[:, None, 2]
    size = np.abs(direction)
    reach = half * (size[:, 0] + size[:, 1] + size[:, 2])
    return (along.min(axis=1) <= reach) & (along.max(axis=1) >= -reach)


def balanced_cell(scene: Scene) -> float:
    """The cell size at which there are about five times as many cells as patches, as a share of the longest side.

    Where patches are spread evenly over the scene, steps and tests of a ray then cost about the same.
    """
    extent = np.maximum((scene.bounds[1] - scene.bounds[0]) / scene.size, 1e-3)
    return float(np.clip((extent.prod() / (5 * len(scene))) ** (1 / 3), 1 / 128, 1 / 4))
