"""Numbers of several runs in blocks of bounded size."""

from collections.abc import Iterator

import numpy as np

__all__ = ["number_blocks"]


def number_blocks(first: np.ndarray, count: np.ndarray, size: int) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """The numbers of all runs, one run after the other.

    Parameters
    ----------
    first, count
        R int64: the first number of each run, and how many it has.
    size
        Numbers of a block, of which the last one may have fewer.

    Yields
    ------
    For each number of a block the run and the number itself, int64 each.
    """
    ends = np.cumsum(np.append(0, count))
    for start in range(0, int(ends[-1]), size):
        own = np.diff(np.clip(ends, start, start + size))
        number = np.repeat(first - ends[:-1], own)
        number += np.arange(start, start + len(number))
        yield np.repeat(np.arange(len(own)), own), number
