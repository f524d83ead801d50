"""Winning pixels: the foremost pixel of each location in each node, without a z-buffer that has to be cleared."""

from typing import NamedTuple

import numpy as np

from golden.base.compiled import compiled
from radiosity.machines.merge.span_lists import SpanLists

__all__ = ["Pixels", "is_before", "pixels_of_spans", "shaded"]


class Pixels(NamedTuple):
    """The pixels that each of P nodes holds, sorted by location within a node.

    Parameters
    ----------
    start
        P + 1 int64: the first pixel of each node, and how many there are.
    location
        K int64: line x width + x.
    depth
        K float64.
    shade
        K uint32: red, green and blue, 8 bits each.
    """

    start: np.ndarray
    location: np.ndarray
    depth: np.ndarray
    shade: np.ndarray


@compiled
def is_before(depth, shade, other_depth, other_shade):
    """A pixel wins if it is nearer. Of two at one depth the lower shade wins: the source is silent, and no order of
    the nodes may change the picture.
    """
    return depth < other_depth or (depth == other_depth and shade < other_shade)


@compiled
def shaded(slope, x):
    """Depth and shade of a span at x."""
    shade = 0
    for field in range(1, 4):
        value = np.floor(slope[field] + x * slope[field + 4] + 0.5)
        shade = shade * 256 + int(min(max(value, 0.0), 255.0))
    return slope[0] + x * slope[4], shade


def pixels_of_spans(spans: SpanLists, nodes: int, width: int) -> Pixels:
    """The modified scanline z-buffer: winning pixels are appended to an array (WPA), which has them in order.

    The scanline array (MSA) has the index of the winner at each x. Spans come by their first x, so the part of a span
    beyond those before it on the line is new: it is appended without a comparison, over indices of earlier lines.

    Parameters
    ----------
    spans
        Sorted by node, line and first x.
    nodes, width
        P, and pixels of a scanline.

    Source: Kurc 1997, section 4.3.
    """
    total = int((spans.right - spans.left + 1).sum())
    location, depth = np.empty(total, dtype=np.int64), np.empty(total)
    shade, start = np.empty(total, dtype=np.uint32), np.zeros(nodes + 1, dtype=np.int64)
    count = _draw(spans.node, spans.line, spans.left, spans.right, spans.slope, width, location, depth, shade, start)
    return Pixels(start, location[:count].copy(), depth[:count].copy(), shade[:count].copy())


@compiled
def _draw(node, line, left, right, slope, width, location, depth, shade, start):
    """Draw all spans; the number of winners."""
    index = np.zeros(width, dtype=np.int64)
    count, extent = 0, -1
    for span in range(len(node)):
        if span == 0 or node[span] != node[span - 1] or line[span] != line[span - 1]:
            extent = -1
        for x in range(left[span], min(right[span], extent) + 1):
            z, colour = shaded(slope[span], x)
            at = index[x]
            if is_before(z, colour, depth[at], shade[at]):
                depth[at], shade[at] = z, colour
        for x in range(max(left[span], extent + 1), right[span] + 1):
            z, colour = shaded(slope[span], x)
            index[x] = count
            location[count], depth[count], shade[count] = line[span] * width + x, z, colour
            count += 1
        extent = max(extent, right[span])
        start[node[span] + 1] = count
    for each in range(1, len(start)):
        start[each] = max(start[each], start[each - 1])
    return count
