"""A grid ray survives while a ray of its window may change: ray by ray."""

from types import SimpleNamespace

import numpy as np
import pytest

from golden.engine.ctu.survival import survivors

ROWS, COLUMNS = 5, 8


def windows(seed):
    """Windows of no, one and several rows and columns, some of them past the end of a row."""
    random = np.random.default_rng(seed)
    first_row = random.integers(0, ROWS, 6)
    return SimpleNamespace(
        first_row=first_row, row_count=np.minimum(np.array([0, 1, 1, 2, 3, 5]), ROWS - first_row),
        first_column=random.integers(0, COLUMNS, 7), column_count=np.array([0, 1, 1, 2, 4, 7, 8]))


def expected(rays, may_change):
    found = np.zeros((len(rays.first_row), len(rays.first_column)), dtype=bool)
    for row, column in np.ndindex(*found.shape):
        rows = range(rays.first_row[row], rays.first_row[row] + rays.row_count[row])
        columns = range(rays.first_column[column], rays.first_column[column] + rays.column_count[column])
        found[row, column] = any(may_change[one, other % COLUMNS] for one in rows for other in columns)
    return found


@pytest.mark.parametrize("share", [0.0, 0.1, 0.5, 1.0])
@pytest.mark.parametrize("seed", range(4))
def test_survivors_are_those_of_each_window(share, seed):
    rays, may_change = windows(seed), np.random.default_rng(seed).random((ROWS, COLUMNS)) < share
    np.testing.assert_array_equal(survivors(rays, may_change), expected(rays, may_change))


def test_a_single_ray_keeps_its_windows():
    rays, may_change = windows(9), np.zeros((ROWS, COLUMNS), dtype=bool)
    for place in np.ndindex(ROWS, COLUMNS):
        may_change[:] = False
        may_change[place] = True
        np.testing.assert_array_equal(survivors(rays, may_change), expected(rays, may_change))
