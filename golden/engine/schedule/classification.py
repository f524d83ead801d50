"""Classification: the home cluster of each patch."""

import numpy as np

from golden.engine.icu.window import Window
from golden.engine.schedule.sections import Partition

__all__ = ["classify", "rays_inside"]


def rays_inside(window: Window, part: np.ndarray, columns: int) -> np.ndarray:
    """Number of rays of each window in a part of the frustum.

    Parameters
    ----------
    window
        Windows of P patches; columns wrap from the last to the first.
    part
        P x 4 (or 4) int64: first column, end column, first row, end row.
    columns
        Columns of the frustum.

    Returns
    -------
    P int64.
    """
    part = np.asarray(part)
    first, end = window.column_first, window.column_first + window.column_count
    # A window that passes the last column wraps to the first: add the same window one turn earlier.
    across = _common(first, end, part[..., 0], part[..., 1]) \
        + _common(first - columns, end - columns, part[..., 0], part[..., 1])
    down = _common(window.row_first, window.row_first + window.row_count, part[..., 2], part[..., 3])
    return across * down


def _common(first, end, other_first, other_end):
    return np.maximum(np.minimum(end, other_end) - np.maximum(first, other_first), 0)


def classify(partition: Partition, window: Window) -> np.ndarray:
    """The home cluster of each patch.

    At every cut it is on the side with more rays of its window, or on the lower side of two equal ones.

    Parameters
    ----------
    partition
        Partition of the dense frustum.
    window
        Windows of P patches in it.

    Returns
    -------
    P int64 numbers of sections.

    Source: Shen 1993, Fig. 4.11, with every patch tested at every cut.
    """
    cluster = np.zeros(len(window.row_first), dtype=np.int64)
    for parts in partition.levels[1:]:
        low, high = (rays_inside(window, parts[2 * cluster + side], partition.columns) for side in (0, 1))
        cluster = 2 * cluster + (high > low)
    return cluster
