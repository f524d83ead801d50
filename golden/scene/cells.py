"""The uniform grid of cells over a scene, and which patches each cell holds."""

import numpy as np

from golden.errors import InputError
from golden.scene.scene import Scene

__all__ = ["FINEST", "Cells", "balanced_cell"]

# A patch also belongs to cells that it misses by this share of the scene's size, so that no rounding in a traversal
# can pass it by.
MARGIN_SHARE = 2.0**-30
# Cells along the longest side at most: 256^3 start numbers are 128 MiB.
FINEST = 256
# Candidate pairs of patch and cell that are looked at together.
BLOCK = 1 << 20


class Cells:
    """Cubic cells from the lower corner of the scene box, each with the ascending numbers of the patches that touch it.

    Parameters
    ----------
    scene
        The patches.
    cell
        Cell size as a share of the scene box's longest side, 1/256 to 1.

    Members
    -------
    size
        Cell size in scene units.
    shape
        Cells along x, y and z.
    lower
        Lower corner of the grid in scene units.
    start, patch
        The patches of cell number c are ``patch[start[c]:start[c + 1]]``; x runs slowest.
    margin
        How near to a cell a patch must come to belong to it, in scene units.

    Errors
    ------
    InputError
        Cell size out of range.
    """

    def __init__(self, scene: Scene, cell: float):
        lower, upper = scene.bounds
        if not 1 / FINEST <= cell <= 1:
            raise InputError(f"Cell size must be 1/{FINEST} to 1 of the scene's longest side, not {cell!r}")
        self.margin = MARGIN_SHARE * scene.size
        self.size = cell * scene.size
        # The outermost patches may lie exactly on the scene box: the margin keeps them, and rays to them, inside.
        self.lower = lower - self.margin
        self.shape = np.maximum(np.ceil((upper - lower + 2 * self.margin) / self.size).astype(int), 1)
        cells, patches = [], []
        for patch, index in self._candidates(scene):
            keep = self._touches(scene.vertices[patch], index)
            cells.append(np.ravel_multi_index(index[keep].T, self.shape))
            patches.append(patch[keep])
        cells, patches = np.concatenate(cells), np.concatenate(patches)
        order = np.lexsort((patches, cells))
        self.patch = patches[order]
        self.start = np.searchsorted(cells[order], np.arange(self.shape.prod() + 1))

    def __len__(self) -> int:
        return int(self.shape.prod())

    def _candidates(self, scene):
        """Blocks of (patch number, cell x y z): every cell that a patch's own box touches."""
        corners = scene.vertices
        first = self._index(corners.min(axis=1) - self.margin)
        extent = self._index(corners.max(axis=1) + self.margin) - first + 1
        total = np.cumsum(extent.prod(axis=1))
        bounds = np.searchsorted(total, np.arange(BLOCK, total[-1] + BLOCK, BLOCK), side="left") + 1
        begin = 0
        for end in np.unique(np.minimum(bounds, len(corners))):
            count = extent[begin:end].prod(axis=1)
            patch = np.repeat(np.arange(begin, end), count)
            rank = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
            rank, z = np.divmod(rank, extent[patch, 2])
            x, y = np.divmod(rank, extent[patch, 1])
            yield patch, first[patch] + np.stack([x, y, z], axis=1)
            begin = end

    def _index(self, point):
        return np.clip(((point - self.lower) / self.size).astype(int), 0, self.shape - 1)

    def _touches(self, vertices, index):
        """Whether patch k comes within the margin of cell k, by separating axes.

        A convex patch and a box are apart if and only if their projections are apart on a box axis, on the patch's
        normal, or on the product of a patch edge and a box axis.
        """
        half = 0.5 * self.size + self.margin
        points = vertices - (self.lower + (index + 0.5) * self.size)[:, None]
        touch = (points.min(axis=1) <= half).all(axis=1) & (points.max(axis=1) >= -half).all(axis=1)
        normal = np.cross(vertices[:, 2] - vertices[:, 0], vertices[:, 3] - vertices[:, 1])
        touch &= _overlap(points, normal, half)
        edges = np.roll(vertices, -1, axis=1) - vertices
        for corner in range(4):
            for axis in range(3):
                touch &= _overlap(points, np.cross(edges[:, corner], np.eye(3)[axis]), half)
        return touch


def _overlap(points, direction, half):
    """Whether the points' span along a direction reaches into that of a cube of half side ``half``."""
    along = np.einsum("kij,kj->ki", points, direction)
    reach = half * np.abs(direction).sum(axis=1)
    return (along.min(axis=1) <= reach) & (along.max(axis=1) >= -reach)


def balanced_cell(scene: Scene) -> float:
    """The cell size at which there are about five times as many cells as patches, as a share of the longest side.

    Where patches are spread evenly over the scene, steps and tests of a ray then cost about the same.
    """
    extent = np.maximum((scene.bounds[1] - scene.bounds[0]) / scene.size, 1e-3)
    return float(np.clip((extent.prod() / (5 * len(scene))) ** (1 / 3), 1 / 128, 1 / 4))
