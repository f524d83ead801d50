"""Subshells divide the rays of a sector among them."""

import numpy as np
import pytest

from golden.engine.ctu.grid_rays import INDEX_FRACTION, hemisphere_rays
from golden.engine.ctu.sector import Sector
from radiosity.machines.paper.subshell_grid import SubshellGrid

SECTOR = Sector(48, 64, 3, 14)
GRID = SubshellGrid(sector=SECTOR, columns=64, extents=(5, 4))


def test_windows_are_a_partition_of_the_sector():
    owner = np.full((16, 64), -1)
    for number, (column, columns, row, rows) in enumerate(zip(*GRID.windows, strict=True)):
        assert (owner[row:row + rows, column:column + columns] == -1).all()
        owner[row:row + rows, column:column + columns] = number
    assert len(GRID) == 12
    inside = np.mgrid[3:14, 48:64]
    assert np.array_equal(owner[3:14, 48:64], GRID.numbers(inside[1], inside[0]))
    assert (np.delete(owner, np.s_[48:64], axis=1) == -1).all()


@pytest.mark.parametrize(("column", "row", "subshell"), [
    (48, 3, 0), (63, 3, 3), (0, 3, 3), (10, 3, 3), (47, 3, 0), (30, 3, 0), (48, 0, 0), (48, 15, 8), (20, 15, 11)])
def test_a_ray_outside_belongs_to_the_nearest_subshell(column, row, subshell):
    assert GRID.numbers(np.array(column), np.array(row)) == subshell


def test_grid_rays_belong_to_the_subshell_at_their_position():
    rays = hemisphere_rays(5, 64, 16)
    owner = GRID.of_grid_rays(rays)
    assert owner.shape == (rays.rows, rays.columns)
    row, column = 4, rays.columns - 1
    position = rays.column_position[column] >> INDEX_FRACTION, rays.row_position[row] >> INDEX_FRACTION
    assert owner[row, column] == GRID.numbers(*position)


@pytest.mark.parametrize("sector", [SECTOR, Sector(0, 64, 0, 16), Sector(7, 30, 0, 9)])
def test_ranges_hold_the_subshells_of_a_window(sector):
    grid, rng = SubshellGrid(sector=sector, columns=64, extents=(5, 4)), np.random.default_rng(3)
    first, columns, top = rng.integers(0, 64, 300), rng.integers(1, 65, 300), rng.integers(0, 16, 300)
    rows = np.minimum(rng.integers(1, 17, 300), 16 - top)
    exact = 0
    for number, (above, below, left, right) in enumerate(zip(*grid.ranges(first, columns, top, rows), strict=True)):
        row, column = np.meshgrid(top[number] + np.arange(rows[number]),
                                  (first[number] + np.arange(columns[number])) % 64, indexing="ij")
        inside = (row >= sector.first_row) & (row < sector.end_row) & (column >= sector.first_column) & (
            column < sector.end_column)
        held = {up * grid.shape[1] + across for up in range(above, below + 1) for across in range(left, right + 1)}
        met = set(grid.numbers(column[inside], row[inside]).tolist())
        assert met <= held
        exact += met == held
    assert exact > 100
