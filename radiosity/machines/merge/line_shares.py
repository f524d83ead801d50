"""Line shares: which scanlines each region of the merge has."""

import heapq

import numpy as np

from golden.base.errors import InputError, check_choice
from radiosity.machines.common.assignment import Assignment, shares

__all__ = ["DIVISIONS", "divide_lines"]

DIVISIONS = ("equal", "recursive", "packed")


def divide_lines(division: str, counts: np.ndarray, regions: int) -> Assignment:
    """Divide the screen among regions, each of which has consecutive new numbers of scanlines.

    ``equal`` gives all regions as many consecutive lines. ``recursive`` cuts the screen in two where both sides have
    the most equal counts, gives a half of the regions to each side, and so on. ``packed`` gives the line with the most
    pixels to the region with the fewest, then the next line; lines without pixels have no region.

    Parameters
    ----------
    division
        A name of `DIVISIONS`.
    counts
        H int64: pixels of each scanline, of all nodes.
    regions
        A power of two up to the scanlines.

    Raises
    ------
    InputError
        The division is none, or the regions are more than the scanlines.

    Source: Kurc 1997, section 4.5.
    """
    height = len(counts)
    check_choice("merge: Division", division, DIVISIONS)
    if regions > height:
        raise InputError(f"merge: Nodes must be at most the {height} scanlines, not {regions}", parameter="nodes")
    order = np.arange(height)
    if division == "equal":
        return Assignment(order=order, bounds=np.append(0, np.cumsum(shares(height, regions))))
    if division == "recursive":
        bounds = np.zeros(regions + 1, dtype=np.int64)
        bounds[regions] = height
        _halve(np.append(0, np.cumsum(counts)), bounds, 0, regions)
        return Assignment(order=order, bounds=bounds)
    owner = _packed(np.asarray(counts), regions)
    return Assignment(order=np.argsort(owner, kind="stable"),
                      bounds=np.searchsorted(np.sort(owner), np.arange(regions + 1)))


def _halve(before, bounds, first, last):
    """Set the bounds between regions ``first`` and ``last``; each side keeps a line for each of its regions."""
    if last - first == 1:
        return
    middle = (first + last) // 2
    low, high = bounds[first] + middle - first, bounds[last] - (last - middle)
    twice = 2 * before[low:high + 1] - before[bounds[first]] - before[bounds[last]]
    bounds[middle] = low + np.argmin(np.abs(twice))
    _halve(before, bounds, first, middle)
    _halve(before, bounds, middle, last)


def _packed(counts, regions):
    """The region of each line, or R without one: a heap of loads gives the lightest one, of equal ones the first."""
    heap = [(0, region) for region in range(regions)]
    owner = np.full(len(counts), regions, dtype=np.int64)
    for line in np.argsort(-counts, kind="stable")[:np.count_nonzero(counts)]:
        load, region = heap[0]
        owner[line] = region
        heapq.heapreplace(heap, (load + int(counts[line]), region))
    return owner
