"""The cell address table: pointer and length of the patch list of each cell."""

import numpy as np

from golden.base.errors import InputError
from golden.engine.ctu.cell_traversal import INDEX_BITS, POSITION_FRACTION
from golden.engine.memsys.patches.patch_table import PatchTable
from golden.scene.cells_kernel import patches_of_cells

__all__ = ["MARGIN", "CellTable"]

# A patch is also listed in cells that it misses by up to this many units of G. The R frame of a hemisphere rounds a
# vertex by up to 2 sqrt(3) units along an axis of G, if it has two bits fewer, and by less than 2^k with k bits fewer;
# the slack of shelling covers all else (docs/exactness.md).
MARGIN = 4
# Fibonacci hashing, 2^32 divided by the golden ratio: numbers that follow each other get keys that are far apart (D. E.
# Knuth, The Art of Computer Programming 3, section 6.4).
SCATTER = 0x9E3779B1


class CellTable:
    """Cells of a scene in G coordinates, each with a count and a pointer into the patch address table.

    Cell number ``(x * shape[1] + y) * shape[2] + z`` covers ``lower + cell * (x, y, z)`` and ``cell`` units more.

    Parameters
    ----------
    vertices
        N x 4 x 3 int64, G coordinates.
    cell
        Cell size in units of G.
    ascending
        Lists of more patches are scattered: neighbours in a list have numbers far apart. Default: in all lists numbers
        ascend. Patches of neighbouring numbers often are neighbours in the scene, with about as many tests each.
    margin
        Units of G by which a patch may miss a cell that lists it.

    Members
    -------
    lower, shape
        Lower corner in G, cells along x, y and z: 3 int64 each.
    count, pointer
        Per cell: patches in it, and the first of its entries in `patches`.
    patches
        The patch address table.
    """

    def __init__(self, vertices: np.ndarray, *, cell: int, ascending: int | None = None, margin: int = MARGIN):
        vertices = np.asarray(vertices, dtype=np.int64)
        points = vertices.reshape(-1, 3)
        self.cell, self.margin = int(cell), margin
        # The outermost patches are exactly on the scene box: the margin keeps them inside.
        self.lower = points.min(axis=0) - self.margin
        self.shape = (points.max(axis=0) + self.margin - self.lower) // self.cell + 1
        start, patch = patches_of_cells(vertices.astype(np.float64), self.lower.astype(np.float64), float(self.cell),
                                        self.shape, float(self.margin))
        self.pointer, self.count = start[:-1].astype(np.int64), np.diff(start).astype(np.int64)
        if ascending is not None:
            key = np.where(np.repeat(self.count > ascending, self.count), patch * SCATTER % (1 << 32), patch)
            patch = patch[np.lexsort((key, np.repeat(np.arange(len(self)), self.count)))]
        self.patches = PatchTable(patch)

    def __len__(self) -> int:
        return len(self.count)

    def number(self, index: np.ndarray) -> np.ndarray:
        """Cell numbers of ``... x 3`` cells (x, y, z)."""
        return (index[..., 0] * self.shape[1] + index[..., 1]) * self.shape[2] + index[..., 2]

    def position(self, point: np.ndarray) -> np.ndarray:
        """Position of a point of G in the grid: 3 int64 from the lower corner, in units of 2^-POSITION_FRACTION cells.

        Raises
        ------
        InputError
            The point is too far from the grid.
        """
        position = ((np.asarray(point) - self.lower) << POSITION_FRACTION) // self.cell
        if (np.abs(position) >> POSITION_FRACTION + INDEX_BITS - 2).any():
            raise InputError(f"cells: The point must be at most {1 << INDEX_BITS - 2} cells from the grid, not "
                             f"{int(np.abs(position).max()) >> POSITION_FRACTION}; use larger cells")
        return position

    def entries(self, cells: np.ndarray) -> np.ndarray:
        """Addresses in the patch address table of all entries of the cells, cell by cell."""
        count = self.count[cells]
        first = np.cumsum(count) - count
        return np.repeat(self.pointer[cells] - first, count) + np.arange(count.sum())
