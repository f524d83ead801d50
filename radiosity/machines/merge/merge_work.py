"""Merge work: the operations of a node that makes and merges pixels."""

from dataclasses import dataclass

from radiosity.machines.common.timing_numbers import TimingNumbers

__all__ = ["CELL_WORDS", "PIXEL_WORDS", "MergeWork"]

CELL_WORDS, PIXEL_WORDS = 2, 3
"""Words of a cell of a z-buffer (depth and shade) and of a pixel that is sent alone (x, depth and shade)."""


@dataclass(frozen=True, kw_only=True)
class MergeWork(TimingNumbers):
    """Operations of the steps of a picture, each of which takes the operation of a `NodeTiming`.

    The source has none of them, only times of whole phases. ``cell`` and ``clearing`` are the means of its table 4.2.
    The others are ours, counted once for all scenes: a triangle has 3 corners moved by a matrix (28 each), divided (2)
    and shaded (20), and a normal (10); a span has 5 increments on each of 2 edges, a depth and 3 colours with their
    slopes, and an insertion into its list (4 more); a pixel has 4 increments, 3 roundings, 3 limits, 2 to pack it, its
    x, a look-up, a comparison and 3 stores. To scatter a pixel takes its address (2) and 2 stores, to compare one a
    comparison more. In a merge of two lists each pixel takes a comparison and 3 copies.

    Parameters
    ----------
    triangle, span, pixel
        Operations on each until it is drawn in a node.
    counting
        On each span, to count the pixels that win.
    scattering, comparing
        On a pixel that enters an empty or an occupied cell of a z-buffer.
    merging, deciding
        On each pixel of two lists that are merged, and on two at the same location.
    cell
        ns to merge a cell of a z-buffer, without its transfer.
    clearing
        ns to clear a cell.

    Raises
    ------
    TypeError, ValueError
        See `TimingNumbers`.

    Source: Kurc 1997, sections 4.3 to 4.6.
    """

    triangle: int = 160
    span: int = 22
    pixel: int = 18
    counting: int = 3
    scattering: int = 4
    comparing: int = 5
    merging: int = 4
    deciding: int = 1
    cell: int = 10_420
    clearing: int = 800
