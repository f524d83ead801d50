"""The mean window is that of the patches so far."""

import numpy as np

from golden.engine.icu.window import Window
from radiosity.machines.paper.mean_window import MeanWindow


def windows(*extents):
    columns, rows = np.array(extents, dtype=np.int64).T
    return Window(np.zeros_like(columns), columns, np.zeros_like(rows), rows)


def test_extents_are_the_mean_columns_and_rows():
    mean = MeanWindow()
    assert mean.extents is None
    mean.add(windows((4, 2), (8, 3)))
    assert mean.extents == (6, 3)
    mean.add(windows((30, 1)))
    assert mean.extents == (14, 2)


def test_windows_without_rays_do_not_count():
    mean = MeanWindow()
    mean.add(windows((0, 0), (0, 0)))
    assert mean.extents is None
    mean.add(windows((1, 1), (0, 0), (0, 0)))
    assert mean.extents == (1, 1)
