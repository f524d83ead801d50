"""Homes of patches against counting ray by ray."""

import numpy as np
import pytest

from golden.engine.icu.window import Window
from golden.engine.schedule.classification import classify, rays_inside
from golden.engine.schedule.sections import cut_sections
from tb.golden.engine.schedule.windows import random_windows

COLUMNS, ROWS = 64, 16


def mask(window, number):
    row, column = np.indices((ROWS, COLUMNS))
    return window[number].holds(column, row, COLUMNS) & (window.rays[number] > 0)


@pytest.fixture(scope="module")
def partition():
    return cut_sections(np.random.default_rng(5).random((ROWS, COLUMNS)) ** 4, clusters=16)


def test_rays_inside_a_part_are_those_of_the_window_there(partition):
    window = random_windows(COLUMNS, ROWS, seed=1)
    for part in np.concatenate(partition.levels):
        inside = rays_inside(window, part, COLUMNS)
        for number in range(len(inside)):
            assert inside[number] == mask(window, number)[part[2]:part[3], part[0]:part[1]].sum()


def test_a_patch_is_at_home_where_more_of_its_window_is_at_every_cut(partition):
    window = random_windows(COLUMNS, ROWS, seed=2)
    home = classify(partition, window)
    for number, cluster in enumerate(home):
        for level in range(1, 5):
            ancestor = cluster >> (4 - level)
            rays = [mask(window, number)[part[2]:part[3], part[0]:part[1]].sum() for part in partition.levels[level]]
            assert rays[ancestor] > rays[ancestor ^ 1] or (rays[ancestor] == rays[ancestor ^ 1] and ancestor % 2 == 0)


def test_a_window_within_a_section_is_at_home_there(partition):
    part = partition.levels[-1]
    window = Window(part[:, 0], part[:, 1] - part[:, 0], part[:, 2], part[:, 3] - part[:, 2])
    assert np.array_equal(classify(partition, window), np.arange(16))


def test_one_cluster_is_the_home_of_everything():
    whole = cut_sections(np.ones((ROWS, COLUMNS)), clusters=1)
    assert (classify(whole, random_windows(COLUMNS, ROWS, seed=3)) == 0).all()
