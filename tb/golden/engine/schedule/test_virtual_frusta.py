"""Blocks of rays against counting ray by ray."""

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.engine.schedule.virtual_frusta import VirtualFrusta
from tb.golden.engine.schedule.windows import random_windows

SHAPES = [(64, 16, 1), (64, 16, 2), (64, 16, 16), (64, 16, 64), (50, 31, 16), (7, 5, 8)]


@pytest.mark.parametrize(("columns", "rows", "ratio"), SHAPES)
def test_overlaps_count_each_ray_of_each_window_once(columns, rows, ratio):
    frusta = VirtualFrusta.of(columns, rows, ratio)
    window = random_windows(columns, rows, seed=ratio)
    expected = np.zeros((len(window.rays), *frusta.shape), dtype=np.int64)
    which, column, row = window.pairs(columns)
    np.add.at(expected, (which, row // frusta.height, column // frusta.width), 1)
    overlap = frusta.overlaps(window)
    counted = np.zeros_like(expected)
    np.add.at(counted, (overlap.window, overlap.row, overlap.column), overlap.rays)
    assert overlap.rays.min() >= 1
    assert np.array_equal(counted, expected)


@pytest.mark.parametrize(("columns", "rows", "ratio"), SHAPES)
def test_a_window_covers_the_frusta_that_have_no_ray_outside_it(columns, rows, ratio):
    frusta = VirtualFrusta.of(columns, rows, ratio)
    window = random_windows(columns, rows, seed=100 + ratio)
    overlap = frusta.overlaps(window)
    assert overlap.covers.any()
    for number in range(0, len(overlap.window), 7):
        row, column = np.indices((rows, columns))
        own = (row // frusta.height == overlap.row[number]) & (column // frusta.width == overlap.column[number])
        inside = window[overlap.window[number]].holds(column, row, columns)
        assert overlap.covers[number] == inside[own].all() or (own & inside).sum() > overlap.rays[number]


@pytest.mark.parametrize(("columns", "rows", "ratio"), SHAPES)
def test_each_frustum_has_its_own_ray_and_shares_keep_the_sum(columns, rows, ratio):
    frusta = VirtualFrusta.of(columns, rows, ratio)
    column, row = frusta.rays
    number = np.arange(column.size).reshape(frusta.shape)
    assert np.array_equal(frusta.spread(number)[row, column], number)
    values = np.random.default_rng(ratio).integers(0, 1000, frusta.shape)
    share = frusta.share(values)
    assert share.shape == (rows, columns)
    assert np.isclose(share.sum(), values.sum())
    assert np.allclose(share * np.bincount(frusta.spread(number).ravel())[frusta.spread(number)], frusta.spread(values))


def test_blocks_are_as_square_as_possible_and_not_higher_than_wide():
    frusta = [VirtualFrusta.of(16, 16, ratio) for ratio in (1, 2, 4, 8, 16, 32)]
    assert [(one.width, one.height) for one in frusta] == [(1, 1), (2, 1), (2, 2), (4, 2), (4, 4), (8, 4)]
    assert VirtualFrusta.of(8, 4, 32).shape == (1, 1)
    for columns, rows in (7, 4), (8, 3):
        with pytest.raises(InputError, match=f"Ratio must leave a ray of {columns} x {rows}, not be 32"):
            VirtualFrusta.of(columns, rows, 32)


def test_ratios_that_make_no_blocks_are_refused():
    for ratio in 0, 3:
        with pytest.raises(InputError, match="Ratio must be a power of two"):
            VirtualFrusta.of(64, 16, ratio)
    for ratio in 2.0, True:
        with pytest.raises(TypeError, match="Ratio must be an int"):
            VirtualFrusta.of(64, 16, ratio)
    with pytest.raises(InputError, match="Ratio must leave a ray of 64 x 16, not be 1024"):
        VirtualFrusta.of(64, 16, 1024)
