import math

import numpy as np
import pytest

from golden.engine.config import PRESETS
from golden.engine.icu.section_clip import SectionWindow
from golden.engine.icu.window_walk import issue_cycles, ray_address, walk_cycles, window_rays, window_tiles

ICU = PRESETS["small"].icu
SIDE = 1 << ICU.tile_bits
# First column, columns, wrapped columns, first row, rows: one ray, borders of tiles, both pieces in one tile, nothing.
CASES = [(0, 1, 0, 0, 1), (SIDE - 1, 2, 0, SIDE - 1, 2), (SIDE + 1, SIDE, 3, 2, 3 * SIDE), (5, 3, 5, 1, 2),
         (3, 0, 0, 4, 0), (2 * SIDE, SIDE, 2 * SIDE, 0, SIDE), (1, 2, 1, 7, 1)]
GENERATOR = np.random.default_rng(1)
CASES += [(int(first), int(GENERATOR.integers(1, 40)), int(GENERATOR.integers(0, first + 1)),
           *map(int, GENERATOR.integers(1, 40, 2))) for first in GENERATOR.integers(0, 60, 12)]


def window(*numbers):
    return SectionWindow(*(np.array([number]) for number in numbers))


def scanned(first, count, wrapped, top, rows):
    """Rays by tile, as a scan in four loops visits them: a tile of both pieces twice."""
    tiles = []
    for tile_row in range(64):
        for columns in (range(first, first + count), range(wrapped)):
            for tile_column in range(64):
                rays = [(tile_column * SIDE + x, tile_row * SIDE + y) for y in range(SIDE) for x in range(SIDE)
                        if tile_column * SIDE + x in columns and tile_row * SIDE + y in range(top, top + rows)]
                tiles += [rays] if rays else []
    return tiles


@pytest.mark.parametrize("case", CASES, ids=str)
def test_scan_is_that_of_loops(case):
    tiles = scanned(*case)
    found = zip(*map(list, window_rays(window(*case), 0, ICU)), strict=True)
    assert list(found) == [ray for rays in tiles for ray in rays]
    assert window_tiles(window(*case), ICU).tolist() == [max(1, len(tiles))]


def test_cycles_are_tiles_or_live_rays_whichever_are_more():
    tiles = window_tiles(window(*CASES[2]), ICU)[0]
    assert [int(walk_cycles(window(*CASES[2]), np.array([live]), ICU)[0]) for live in (0, tiles, tiles + 1)] == [
        tiles, tiles, tiles + 1]


@pytest.mark.parametrize("across", [1, 3])
def test_addresses_number_tiles_then_rays(across):
    """Every ray of a section has an address of its own, tile by tile, in a tile row by row."""
    expected = 0
    for tile_row in range(2):
        for tile_column in range(across):
            for y in range(SIDE):
                for x in range(SIDE):
                    found = ray_address(np.array(tile_column * SIDE + x), np.array(tile_row * SIDE + y), across, ICU)
                    assert found == expected
                    expected += 1


@pytest.mark.parametrize("lanes", [1, 2, 5])
def test_lanes_issue_rays_of_one_tile_of_one_patch(lanes):
    random = np.random.default_rng(7)
    rays = {(int(patch), int(column), int(row)) for patch, column, row in zip(
        random.integers(0, 4, 300), random.integers(0, 3 * SIDE, 300), random.integers(0, 2 * SIDE, 300), strict=True)}
    expected = [0] * 4
    for patch in range(4):
        for across in range(3):
            for down in range(2):
                live = [ray for ray in rays if (ray[0], ray[1] // SIDE, ray[2] // SIDE) == (patch, across, down)]
                expected[patch] += math.ceil(len(live) / lanes)
    patch, column, row = np.array(sorted(rays, key=hash)).T
    assert issue_cycles(patch, column, row, lanes, ICU).tolist() == expected
