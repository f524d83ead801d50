"""The patches of each cell are the same without numba."""

import numpy as np
import pytest

from golden.scene.cells import Cells
from tb.golden.soups import soup


@pytest.mark.parametrize("cell", [0.5, 0.11])
@pytest.mark.parametrize("seed", range(2))
def test_numpy_finds_the_patches_that_numba_finds(seed, cell):
    compiled, other = (Cells(soup(seed), cell, compiled=way) for way in (True, False))
    np.testing.assert_array_equal(compiled.start, other.start)
    np.testing.assert_array_equal(compiled.patch, other.patch)


def test_blocks_of_candidates_join(monkeypatch):
    """Each patch has more candidates than a block: none is lost or found twice."""
    scene = soup(0)
    whole = Cells(scene, 0.11, compiled=False)
    monkeypatch.setattr("golden.scene.cells.BLOCK", 7)
    parts = Cells(scene, 0.11, compiled=False)
    np.testing.assert_array_equal(parts.start, whole.start)
    np.testing.assert_array_equal(parts.patch, whole.patch)
