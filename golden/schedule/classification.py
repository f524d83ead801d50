"""Classification: the cluster in which each patch is at home."""

import numpy as np

from golden.icu.window import Window
from golden.schedule.sections import Partition

__all__ = ["classify", "rays_inside"]


def rays_inside(window: Window, part: np.ndarray, columns: int) -> np.ndarray:
    """How many rays of each window lie in a part.

    Parameters
    ----------
    window
        Of P patches; columns go on from the last to the first.
    part
        P x 4 (or 4) int64: first column, end column, first row, end row.
    columns
        Of the frustum.

    Returns
    -------
    P int64.
    """
    part = np.asarray(part)
    first, end = window.column_first, window.column_first + window.column_count
    # What passes the last column goes on at the first: the same window one turn earlier.
    across = _common(first, end, part[..., 0], part[..., 1]) \
        + _common(first - columns, end - columns, part[..., 0], part[..., 1])
    down = _common(window.row_first, window.row_first + window.row_count, part[..., 2], part[..., 3])
    return across * down


def _common(first, end, other_first, other_end):
    return np.maximum(np.minimum(end, other_end) - np.maximum(first, other_first), 0)


def classify(partition: Partition, window: Window) -> np.ndarray:
    """The cluster of each patch: at every cut it goes to the side that holds more rays of its window, if equal to the
    lower.

    Parameters
    ----------
    partition
        Of the dense frustum.
    window
        The patches' windows in it.

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
