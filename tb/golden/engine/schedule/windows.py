"""Drawn windows."""

import numpy as np

from golden.engine.icu.window import Window

__all__ = ["random_windows"]


def random_windows(columns, rows, seed, count=60):
    """Windows of all sizes, some without rays, some the whole ring, some across the last column."""
    random = np.random.default_rng(seed)
    column_count, row_first = random.integers(0, columns + 1, count), random.integers(0, rows, count)
    row_count = np.minimum(random.integers(0, rows + 1, count), rows - row_first)
    return Window(random.integers(0, columns, count), column_count, row_first, row_count)
