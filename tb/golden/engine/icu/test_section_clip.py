from types import SimpleNamespace

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from golden.engine.config import Config
from golden.engine.ctu.sector import Sector
from golden.engine.icu.section_clip import section_clip
from golden.engine.icu.window import Window
from golden.engine.stimulus.frusta import random_screen
from tb.lib.schedules import SETTINGS


@st.composite
def windows_and_sections(draw):
    """A frustum of 8 x 4 rays, a section of it, and windows: empty, of one ray, whole, wrapped, and between."""
    is_screen = draw(st.booleans())
    record = SimpleNamespace(is_screen=is_screen, columns=8, rows=4)

    def extent(count, wraps=False):
        first = draw(st.integers(0, count - 1))
        return first, draw(st.integers(0, count if wraps else count - first))

    windows = [(*extent(8, not is_screen), *extent(4)) for _ in range(draw(st.integers(1, 4)))]
    first, across = extent(8)
    top, down = extent(4)
    section = Sector(first, first + max(across, 1), top, top + max(down, 1))
    return record, section, Window(*np.array(windows).T)


@settings(SETTINGS, max_examples=120)
@given(windows_and_sections())
def test_the_two_pieces_are_the_windows_rays_of_the_section(drawn):
    record, section, windows = drawn
    clipped = section_clip(windows, section, record)
    column, row = np.arange(record.columns), np.arange(record.rows)[:, None]
    for k in range(len(windows.rays)):
        expected = windows[[k]].holds(column, row, record.columns) & section.mask(record)
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
