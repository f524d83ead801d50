"""Sections that fit a ray memory: all rays once, whole tiles, no more sections than needed."""

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.engine.config import PRESETS
from golden.engine.ctu.sector import Sector
from golden.engine.jobs.descriptor import section_tiles
from golden.engine.jobs.tile_sections import halves, most_sections, tile_sections, window_sections

# 256 tiles of 4 x 4 rays.
CONFIG = PRESETS["small"]


def cover(sections, columns, rows):
    """How many of the sections each ray is in; none has other rays."""
    covered = np.zeros((rows, columns), dtype=int)
    for one in sections:
        assert 0 <= one.first_column < one.end_column <= columns
        assert 0 <= one.first_row < one.end_row <= rows
        covered[one.first_row:one.end_row, one.first_column:one.end_column] += 1
    return covered


@pytest.mark.parametrize(("columns", "rows", "clusters", "count"), [
    (128, 32, 1, 1), (129, 32, 1, 2), (128, 33, 1, 2), (1, 1, 1, 1), (64, 64, 4, 4), (256, 64, 1, 4), (90, 50, 1, 2),
    (1024, 1024, 2, 256), (1021, 517, 1, 256)])
def test_sections_are_as_few_as_fit_and_cover_every_ray_once(columns, rows, clusters, count):
    sections = tile_sections(columns, rows, CONFIG, clusters=clusters)
    assert len(sections) == count
    assert (cover(sections, columns, rows) == 1).all()
    for one in sections:
        assert 1 <= section_tiles(one, CONFIG) <= 256
        assert one.first_column % 4 == one.first_row % 4 == 0


@pytest.mark.parametrize("clusters", [1, 8])
def test_sections_of_uneven_work_still_fit(clusters):
    random = np.random.default_rng(1)
    for _ in range(10):
        columns, rows = random.integers(64, 300, 2).tolist()
        work = random.random((rows, columns)) ** 8 * (random.random(columns) < 0.2)
        sections = tile_sections(columns, rows, CONFIG, clusters=clusters, workload=work)
        assert (cover(sections, columns, rows) == 1).all()
        assert max(section_tiles(one, CONFIG) for one in sections) <= 256


def test_a_group_shares_the_work_and_not_the_rays():
    work = np.ones((32, 64))
    work[:, :16] = 9
    left, right = tile_sections(64, 32, CONFIG, clusters=2, workload=work)
    assert (left, right) == (Sector(0, 12, 0, 32), Sector(12, 64, 0, 32))


@pytest.mark.parametrize(("columns", "rows", "most"), [
    (1, 1, 1), (4, 4, 1), (5, 4, 2), (1024, 4, 2), (8, 8, 4), (12, 9, 4), (64, 16, 32), (4, 256, 1)])
def test_the_most_sections_have_a_tile_each(columns, rows, most):
    assert most_sections(columns, rows, CONFIG) == most
    assert len(tile_sections(columns, rows, CONFIG, clusters=most)) == most
    with pytest.raises(InputError, match="cannot be cut for"):
        tile_sections(columns, rows, CONFIG, clusters=2 * most)


@pytest.mark.parametrize(("section", "expected"), [
    (Sector(0, 64, 0, 8), [Sector(0, 32, 0, 8), Sector(32, 64, 0, 8)]),
    (Sector(40, 62, 4, 9), [Sector(40, 52, 4, 9), Sector(52, 62, 4, 9)]),
    (Sector(0, 5, 0, 4), [Sector(0, 4, 0, 4), Sector(4, 5, 0, 4)]),
    (Sector(8, 12, 0, 64), [Sector(8, 12, 0, 64)])])
def test_halves_are_of_whole_tiles(section, expected):
    assert [*halves(section, CONFIG)] == expected


def test_windows_have_all_their_rays_and_whole_tiles_of_them():
    random = np.random.default_rng(2)
    for count in (1, 3, 40, 4000):
        columns, rows = random.integers(30, 600, 2).tolist()
        column, row = random.integers(0, columns, count), random.integers(0, rows, count)
        sections = window_sections(column, row, columns=columns, rows=rows, config=CONFIG)
        covered, tiles = cover(sections, columns, rows), np.zeros((rows, columns), dtype=int)
        for x, y in zip(column // 4 * 4, row // 4 * 4, strict=True):
            tiles[y:y + 4, x:x + 4] = 1
        np.testing.assert_array_equal(covered, tiles)
        assert max(section_tiles(one, CONFIG) for one in sections) <= 256


def test_a_rectangle_of_tiles_is_one_window_if_it_fits():
    def sections(columns, rows):
        row, column = np.divmod(np.arange(columns * rows), columns)
        return window_sections(column + 8, row + 4, columns=2048, rows=2048, config=CONFIG)

    assert sections(12, 7) == (Sector(8, 20, 4, 12),)
    assert sections(64, 68) == (Sector(8, 72, 4, 68), Sector(8, 72, 68, 72))
    assert sections(1028, 4) == (Sector(8, 1032, 4, 8), Sector(1032, 1036, 4, 8))
