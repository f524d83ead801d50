"""The uniform grid of cells over a scene, with the patches of each cell."""

import numpy as np

from golden.base.errors import InputError
from golden.scene.cells_kernel import patches_of_cells
from golden.scene.scene import Scene

__all__ = ["FINEST", "Cells", "balanced_cell", "check_cell_size"]

# A patch also belongs to cells that it misses by up to this share of the scene's size, so that rounding in a traversal
# misses no patch.
MARGIN_SHARE = 2.0**-30
# Most cells along the longest side: 256^3 start numbers are 128 MiB.
FINEST = 256


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
    cell
        Cell size as a share of the scene box's longest side, 1/256 to 1.

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

    def __init__(self, scene: Scene, cell: float):
        lower, upper = scene.bounds
        check_cell_size(cell)
        self.margin = MARGIN_SHARE * scene.size
        self.size = cell * scene.size
        # The outermost patches may be exactly on the scene box: the margin keeps them, and rays to them, inside.
        self.base = lower
        self.shape = np.maximum(np.ceil((upper - lower + 2 * self.margin) / self.size).astype(int), 1)
        self.start, self.patch = patches_of_cells(
            scene.vertices - lower, np.full(3, -self.margin), self.size, self.shape, self.margin)

    def __len__(self) -> int:
        return int(self.shape.prod())


def balanced_cell(scene: Scene) -> float:
    """The cell size at which there are about five times as many cells as patches, as a share of the longest side.

    Where patches are spread evenly over the scene, steps and tests of a ray then cost about the same.
    """
    extent = np.maximum((scene.bounds[1] - scene.bounds[0]) / scene.size, 1e-3)
    return float(np.clip((extent.prod() / (5 * len(scene))) ** (1 / 3), 1 / 128, 1 / 4))
