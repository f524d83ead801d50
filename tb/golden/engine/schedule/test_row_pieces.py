"""Searches of the generator of grid rays follow from which grid rays a section has."""

import numpy as np
import pytest

from golden.cast.hemisphere import Hemisphere
from golden.engine.config import PRESETS
from golden.engine.ctu.grid_rays import hemisphere_rays
from golden.engine.ctu.sector import Sector, sector_rays
from golden.engine.frustum import hemisphere_record
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.schedule.ceiling_points import ceiling_points
from golden.engine.schedule.row_pieces import row_pieces
from golden.scene.builtin import builtin_scene

COLUMNS, ROWS = 256, 64


@pytest.fixture(scope="module")
def record():
    scene = builtin_scene("cornell")
    points, down = ceiling_points(scene)
    geometry = PatchGeometry.of(scene, PRESETS["tiny"].numbers, points)
    return hemisphere_record(Hemisphere(COLUMNS, ROWS), geometry.coordinates, points[5], down)


def rows_of(section, record, shell=9):
    rays = hemisphere_rays(shell, COLUMNS, ROWS)
    return row_pieces(rays, section, record), sector_rays(rays, section, record)


def test_a_whole_frustum_is_searched_once(record):
    found, mask = rows_of(Sector.whole(record), record)
    assert np.array_equal(found.row, np.flatnonzero(mask.any(axis=1)))
    assert (found.pieces == 1).all()
    assert found.searches.tolist() == [1] + [0] * (len(found.row) - 1)


@pytest.mark.parametrize("first_row", [0, 28])
def test_rows_with_other_columns_are_searched_anew(record, first_row):
    found, mask = rows_of(Sector(80, 150, first_row, first_row + 30), record)
    is_other = (mask[found.row][1:] != mask[found.row][:-1]).any(axis=1)
    assert is_other.any()
    assert found.searches.tolist() == [1, *is_other.astype(int)]


def test_a_section_at_the_last_column_has_two_arcs(record):
    found, mask = rows_of(Sector(204, COLUMNS, 36, ROWS), record)
    begins = (mask & ~np.roll(mask, 1, axis=1))[found.row]
    # A run that goes on from the last column to the first one is two arcs.
    assert (mask[found.row][:, 0] & mask[found.row][:, -1]).all()
    assert (begins.sum(axis=1) == 1).all()
    assert (found.pieces == 2).all()
    assert found.searches[0] == 2
