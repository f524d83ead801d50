"""Every cell holds the patches that touch it."""

import numpy as np
import pytest

from golden.scene.cells import Cells
from tb.golden.scene.touched_cells import touched_cells
from tb.golden.soups import soup


@pytest.mark.parametrize("cell", [0.5, 0.11, 0.04])
@pytest.mark.parametrize("seed", range(3))
def test_cells_hold_the_patches_that_no_axis_separates_from_them(seed, cell):
    scene = soup(seed)
    cells = Cells(scene, cell)
    start, patch = touched_cells(scene.vertices - cells.base, lower=-cells.margin, size=cells.size, shape=cells.shape,
                                 margin=cells.margin)
    np.testing.assert_array_equal(cells.start, start)
    np.testing.assert_array_equal(cells.patch, patch)
