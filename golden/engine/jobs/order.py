"""The order of the sections of a phase in the queue."""

import numpy as np

__all__ = ["TAIL", "long_and_short", "longest_first_at_the_end", "proximity_order"]

# Sections for each cluster at the end of a phase that are ordered by their length instead of their origins.
TAIL = 2


def proximity_order(origins: np.ndarray) -> np.ndarray:
    """An order in which neighbours are near each other, so that caches hold what the next frustum needs.

    It begins with the origin farthest from the mean and goes on with the nearest one that is left. Of equal distances
    the lower number is first.

    Parameters
    ----------
    origins
        M x 3, positions.

    Returns
    -------
    M int64, a permutation.
    """
    left = np.asarray(origins, dtype=np.float64)
    numbers, order = np.arange(len(left)), np.empty(len(left), dtype=np.int64)
    nearest = np.argmax(_distance(left, left.mean(axis=0))) if len(left) else 0
    for index in range(len(order)):
        order[index], here = numbers[nearest], left[nearest]
        numbers, left = np.delete(numbers, nearest), np.delete(left, nearest, axis=0)
        nearest = np.argmin(_distance(left, here)) if len(left) else 0
    return order


def longest_first_at_the_end(cycles: np.ndarray, *, clusters: int) -> np.ndarray:
    """The order of sections that the first free of ``clusters`` clusters takes: the last ones by falling length.

    The last `TAIL` sections for each cluster are reordered, so that short ones even out the ends of the clusters.

    Parameters
    ----------
    cycles
        S float64, predicted cycles of the sections in their order.
    clusters
        Number of clusters.

    Returns
    -------
    S int64, a permutation.
    """
    cycles = np.asarray(cycles, dtype=np.float64)
    first = max(0, len(cycles) - TAIL * clusters)
    order = np.arange(len(cycles))
    order[first:] = first + np.argsort(-cycles[first:], kind="stable")
    return order


def long_and_short(cycles: np.ndarray) -> np.ndarray:
    """The order in which sections of the longer half and of the shorter half alternate, both by falling length.

    The results of a section are written while its cluster casts the next one. Short sections in all clusters at the
    same time would wait for the results of those before them and for the memory port. The last sections are among the
    shortest, so the clusters end at about the same time.

    Parameters
    ----------
    cycles
        S float64, predicted cycles of the sections.

    Returns
    -------
    S int64, a permutation.
    """
    falling = np.argsort(-np.asarray(cycles, dtype=np.float64), kind="stable")
    half = (len(falling) + 1) // 2
    order = np.empty(len(falling), dtype=np.int64)
    order[0::2], order[1::2] = falling[:half], falling[half:]
    return order


def _distance(points, origin):
    return np.square(points - origin).sum(axis=1)
