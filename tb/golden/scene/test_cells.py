"""Every cell holds the patches that touch it."""

import numpy as np
import pytest

from golden.scene.cells import Cells
from tb.golden.scene.touched_cells import touched_cells
from tb.golden.soups import soup


@pytest.mark.parametrize("cell", [0.5, 0.1, 0.04])
@pytest.mark.parametrize("seed", range(3))
def test_points_of_a_patch_lie_in_cells_that_hold_it(seed, cell):
    scene = soup(seed)
    cells = Cells(scene, cell)
    random = np.random.default_rng(seed)
    u, v = random.random((2, 200, len(scene), 1))
    corner = scene.vertices
    points = (1 - v) * ((1 - u) * corner[:, 0] + u * corner[:, 1]) + v * ((1 - u) * corner[:, 3] + u * corner[:, 2])
    points = np.concatenate([points, np.moveaxis(corner, 1, 0)])
    index = ((points - cells.base + cells.margin) / cells.size).astype(int)
    assert (index >= 0).all()
    assert (index < cells.shape).all()
    number = np.ravel_multi_index(np.moveaxis(index, 2, 0), cells.shape)
    held = set(zip(np.repeat(np.arange(len(cells)), np.diff(cells.start)).tolist(), cells.patch.tolist(), strict=True))
    for patch in range(len(scene)):
        assert {(cell, patch) for cell in number[:, patch].tolist()} <= held


@pytest.mark.parametrize("seed", range(3))
def test_no_cell_holds_a_patch_that_is_clearly_outside(seed):
    scene = soup(seed)
    cells = Cells(scene, 0.05)
    cell = np.repeat(np.arange(len(cells)), np.diff(cells.start))
    index = np.stack(np.unravel_index(cell, cells.shape), axis=1)
    centre = cells.base - cells.margin + (index + 0.5) * cells.size
    distance = np.abs(np.einsum("kj,kj->k", centre - scene.vertices[cells.patch, 0], scene.normals[cells.patch]))
    assert (distance <= 0.5 * np.sqrt(3) * cells.size + 2 * cells.margin).all()
    low, high = scene.vertices[cells.patch].min(axis=1), scene.vertices[cells.patch].max(axis=1)
    assert (low <= centre + 0.5 * cells.size + 2 * cells.margin).all()
    assert (high >= centre - 0.5 * cells.size - 2 * cells.margin).all()


def test_patches_of_a_cell_ascend():
    cells = Cells(soup(0), 0.1)
    for start, end in zip(cells.start[:-1], cells.start[1:], strict=True):
        assert (np.diff(cells.patch[start:end]) > 0).all()


@pytest.mark.parametrize("cell", [0.5, 0.11])
@pytest.mark.parametrize("seed", range(2))
def test_cells_hold_the_patches_that_no_axis_separates_from_them(seed, cell):
    scene = soup(seed)
    cells = Cells(scene, cell)
    start, patch = touched_cells(scene.vertices - cells.base, lower=-cells.margin, size=cells.size, shape=cells.shape,
                                 margin=cells.margin)
    np.testing.assert_array_equal(cells.start, start)
    np.testing.assert_array_equal(cells.patch, patch)
