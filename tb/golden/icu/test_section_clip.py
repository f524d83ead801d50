import numpy as np
import pytest

from golden.config import Config
from golden.ctu.sector import Sector
from golden.icu.section_clip import section_clip
from golden.icu.window import Window
from golden.stimulus.frusta import random_hemisphere, random_screen
from golden.stimulus.icu.section_clip import draw_windows

SECTIONS = [(0, None, 0, None), (0, 20, 3, 9), (7, None, 0, 5), (13, 14, 4, 5), (11, 43, 2, None)]


@pytest.mark.parametrize("frustum", [random_hemisphere, random_screen])
@pytest.mark.parametrize("bounds", SECTIONS)
def test_the_two_pieces_are_the_windows_rays_of_the_section(frustum, bounds):
    random = np.random.default_rng(5)
    record = frustum(random, Config())
    a, b, c, d = bounds
    section = Sector(a, b or record.columns, c, d or record.rows)
    given = draw_windows(random, record, 200)
    clipped = section_clip(given, section, record)
    column, row = np.arange(record.columns), np.arange(record.rows)[:, None]
    for k in range(200):
        expected = given[[k]].holds(column, row, record.columns) & section.mask(record)
        pieces = np.zeros((record.rows, record.columns), dtype=int)
        rows = slice(section.first_row + clipped.row_first[k],
                     section.first_row + clipped.row_first[k] + clipped.row_count[k])
        for first, count in ((clipped.column_first[k], clipped.column_count[k]), (0, clipped.wrapped_count[k])):
            pieces[rows, section.first_column + first:section.first_column + first + count] += 1
        assert (pieces == expected).all()
        assert pieces.sum() == clipped.rays[k]


def test_a_window_outside_the_section_has_no_numbers():
    record = random_screen(np.random.default_rng(1), Config())
    window = Window(*(np.array([value]) for value in (2, 5, 3, 4)))
    clipped = section_clip(window, Sector(20, 30, 0, record.rows), record)
    assert [int(value[0]) for value in vars(clipped).values()] == [0, 0, 0, 0, 0]
