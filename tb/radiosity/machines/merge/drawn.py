"""Drawn triangles and spans, and plain pictures of them."""

import numpy as np

from radiosity.machines.merge.screen_triangles import ScreenTriangles
from radiosity.machines.merge.span_lists import SpanLists

__all__ = ["drawn_triangles", "plain_picture", "spans_of"]


def drawn_triangles(seed, count, *, width, height, size=12.0):
    """Triangles anywhere on and beside the screen, in the order of the scene."""
    rng = np.random.default_rng(seed)
    middle = rng.uniform((-5, -5, 0), (width + 5, height + 5, 1), (count, 3))
    corners = middle[:, None] + rng.uniform(-1, 1, (count, 3, 3)) * (size, size, 0.2)
    return ScreenTriangles(corners, rng.uniform(0, 255, (count, 3, 3)), count), np.arange(count)


def spans_of(rows, *, slope=None):
    """Spans of (node, line, left, right), which are flat and have the depth of their number unless given."""
    node, line, left, right = np.array(rows, dtype=np.int64).reshape(-1, 4).T
    if slope is None:
        slope = np.zeros((len(node), 8))
        slope[:, 0] = np.arange(len(node))
    order = np.lexsort((left, line, node))
    return SpanLists(node[order], line[order], left[order], right[order], slope[order])


def plain_picture(spans, width, height):
    """H x W x 3 uint8 by a z-buffer of the whole screen that is cleared, span after span; and where it is active."""
    depth, shade = np.full((height, width), np.inf), np.zeros((height, width), dtype=np.int64)
    for line, left, right, slope in zip(spans.line, spans.left, spans.right, spans.slope, strict=True):
        x = np.arange(left, right + 1)
        z = slope[0] + x * slope[4]
        colour = np.zeros(len(x), dtype=np.int64)
        for field in (1, 2, 3):
            level = np.clip(np.floor(slope[field] + x * slope[field + 4] + 0.5), 0, 255)
            colour = 256 * colour + level.astype(np.int64)
        row = slice(left, right + 1)
        wins = (z < depth[line, row]) | ((z == depth[line, row]) & (colour < shade[line, row]))
        depth[line, row] = np.where(wins, z, depth[line, row])
        shade[line, row] = np.where(wins, colour, shade[line, row])
    picture = np.stack([shade >> 16, shade >> 8 & 255, shade & 255], axis=2).astype(np.uint8)
    return picture, np.isfinite(depth)
