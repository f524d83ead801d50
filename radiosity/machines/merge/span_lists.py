"""Span lists: the intersections of triangles with scanlines."""

from typing import NamedTuple

import numpy as np

from golden.base.compiled import compiled
from radiosity.machines.merge.screen_triangles import ScreenTriangles

__all__ = ["SpanLists", "extended_counts", "pixel_counts", "span_lists"]

_FIELDS = 8


class SpanLists(NamedTuple):
    """S spans, sorted by node, line and first x.

    Parameters
    ----------
    node, line
        S int64: whose it is, and on which scanline.
    left, right
        S int64: first and last x.
    slope
        S x 8 float64: depth, red, green and blue at x = 0, then what they gain with each x.
    """

    node: np.ndarray
    line: np.ndarray
    left: np.ndarray
    right: np.ndarray
    slope: np.ndarray


def pixel_counts(spans: SpanLists, nodes: int) -> np.ndarray:
    """P int64: the pixels that each node generates."""
    return np.bincount(spans.node, spans.right - spans.left + 1, nodes).astype(np.int64)


def extended_counts(spans: SpanLists, nodes: int, height: int) -> np.ndarray:
    """P x H int64: locations that the spans of each node cover on each line, counted without drawing them.

    Spans that meet or touch become one. The printed algorithm keeps the last of these alone; ours adds them.

    Source: Kurc 1997, section 4.5.2, Fig. 4.2.
    """
    row, width = spans.node * height + spans.line, spans.right.max(initial=0) + 1
    # All rows one after the other: what a span covers beyond those before it.
    first, end = row * width + spans.left, np.maximum.accumulate(row * width + spans.right + 1)
    covered = end - np.maximum(first, np.append(0, end[:-1]))
    return np.bincount(row, covered, nodes * height).astype(np.int64).reshape(nodes, height)


def span_lists(triangles: ScreenTriangles, node: np.ndarray, width: int, height: int,
               line: np.ndarray | None = None) -> SpanLists:
    """Spans of all triangles, on lines with new numbers.

    A span reaches from the rounded first to the rounded last intersection, both included. The source does not say which
    pixels it has; by this rule neighbours share about a pixel for each span, which its numbers of pixels suggest.

    Parameters
    ----------
    triangles
        On the screen.
    node
        N int64: the node that has each triangle.
    width, height
        Pixels of the screen.
    line
        H int64: the new number of each scanline. Default: its own.

    Source: Kurc 1997, section 4.3.
    """
    line = np.arange(height) if line is None else np.asarray(line, dtype=np.int64)
    low = np.clip(np.ceil(triangles.corners[:, :, 1].min(axis=1)), 0, height).astype(np.int64)
    high = np.clip(np.floor(triangles.corners[:, :, 1].max(axis=1)), -1, height - 1).astype(np.int64)
    rows = np.maximum(high - low + 1, 0)
    total = int(rows.sum())
    found, slope = np.zeros((4, total), dtype=np.int64), np.zeros((total, _FIELDS))
    count = _fill(np.concatenate([triangles.corners, triangles.colour], axis=2), np.asarray(node, dtype=np.int64), low,
                  high, width, line, found, slope)
    order = np.lexsort((found[2, :count], found[1, :count], found[0, :count]))
    return SpanLists(*np.ascontiguousarray(found[:, :count][:, order]), slope[:count][order])


@compiled
def _fill(corners, node, low, high, width, line, found, slope):
    """Write all spans that are on the screen; their number."""
    count = 0
    ends = np.empty((2, 5))
    for triangle in range(len(corners)):
        for y in range(low[triangle], high[triangle] + 1):
            met = 0
            for corner in range(3):
                a, b = corners[triangle, corner], corners[triangle, (corner + 1) % 3]
                if (a[1] - y) * (b[1] - y) > 0 or a[1] == b[1]:
                    continue
                share = (y - a[1]) / (b[1] - a[1])
                x = a[0] + share * (b[0] - a[0])
                # A corner on the scanline is met twice, the far one of the edges is kept.
                if met == 0 or x < ends[0, 0]:
                    if met == 0:
                        ends[1, 0] = x
                        for field in range(1, 5):
                            ends[1, field] = a[field + 1] + share * (b[field + 1] - a[field + 1])
                    ends[0, 0] = x
                    for field in range(1, 5):
                        ends[0, field] = a[field + 1] + share * (b[field + 1] - a[field + 1])
                elif x > ends[1, 0]:
                    ends[1, 0] = x
                    for field in range(1, 5):
                        ends[1, field] = a[field + 1] + share * (b[field + 1] - a[field + 1])
                met += 1
            if met == 0:
                continue
            left, right = int(np.floor(ends[0, 0] + 0.5)), int(np.floor(ends[1, 0] + 0.5))
            if right < 0 or left >= width:
                continue
            extent = ends[1, 0] - ends[0, 0]
            for field in range(4):
                # An extent below a pixel has the values of its first end: slopes would exceed the triangle's.
                gain = (ends[1, field + 1] - ends[0, field + 1]) / extent if extent >= 1 else 0.0
                slope[count, field] = ends[0, field + 1] - ends[0, 0] * gain
                slope[count, field + 4] = gain
            found[0, count], found[1, count] = node[triangle], line[y]
            found[2, count], found[3, count] = max(left, 0), min(right, width - 1)
            count += 1
    return count
