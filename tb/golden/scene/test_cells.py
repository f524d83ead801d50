"""Every cell holds the patches that touch it."""

import numpy as np
import pytest

from golden.scene.cells import Cells
from tb.golden.light.scenes import BLACK, rectangle, scene_of
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


@pytest.mark.parametrize(("share", "columns"), [(0.5, [0, 1]), (1.5, [0])])
def test_a_patch_is_listed_in_cells_that_it_misses_by_less_than_the_margin(share, columns):
    """Before the first border across x, which is the margin before a quarter of the scene."""
    x = 0.25 - (1 + share) * 2.0**-30
    sides = [rectangle((side, 0, 0), (0, 1, 0), (0, 0, 1)) for side in (0, 1)]
    cells = Cells(scene_of((np.array([*sides, rectangle((x, 0.3, 0.3), (0, 0.1, 0), (0, 0, 0.1))]), BLACK)), 0.25)
    listed = np.searchsorted(cells.start, np.flatnonzero(cells.patch == 2), side="right") - 1
    assert np.unravel_index(listed, cells.shape)[0].tolist() == columns
