import numpy as np

from golden.engine.icu.window import Window, make_window
from tb.golden.engine.icu.patches import hemisphere, screen


def test_pairs_are_the_rays_that_the_window_holds():
    random = np.random.default_rng(1)
    window = Window(random.integers(0, 16, 40), random.integers(1, 17, 40), random.integers(0, 4, 40),
                    random.integers(0, 5, 40))
    which, column, row = window.pairs(16)
    listed = np.zeros((40, 8, 16), dtype=bool)
    listed[which, row, column] = True
    everywhere = window[np.arange(40)[:, None, None]].holds(np.arange(16), np.arange(8)[:, None], 16)
    assert (listed == everywhere).all()
    assert len(which) == listed.sum() == window.rays.sum()


def test_windows_are_clipped_to_the_grid_and_empty_ones_are_all_zero():
    ends = [np.array(values) for values in ([-3, 14, 5, 2], [1, 17, 4, 3], [-9, 2, 0, 9], [99, 3, 1, 12])]
    never = np.array([False, False, False, False])
    ring = make_window(hemisphere(16, 8), never, *ends)
    assert ring.column_first.tolist() == [13, 14, 0, 0]
    assert ring.column_count.tolist() == [5, 4, 0, 0]
    assert ring.row_count.tolist() == [8, 2, 0, 0]
    flat = make_window(screen(16, 8), never, *ends)
    assert flat.column_first.tolist() == [0, 14, 0, 0]
    assert flat.column_count.tolist() == [2, 2, 0, 0]
    assert (make_window(hemisphere(16, 8), ~never, *ends).rays == 0).all()


def test_only_keeps_the_others_windows_and_empties_these():
    window = Window(*np.full((4, 3), 2))
    assert window.only(np.array([True, False, True])).rays.tolist() == [4, 0, 4]
