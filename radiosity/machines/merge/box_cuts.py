"""Box cuts: the screen is cut in two again and again, by exact counts of the boxes on both sides."""

from functools import partial

import numpy as np

from golden.base.errors import InputError
from radiosity.machines.merge.work_weights import WorkWeights

__all__ = ["axes_of", "can_be_cut", "cut_boxes"]

_X, _Y = 0, 1


def axes_of(splitter: str, levels: int) -> list[tuple[int, ...]]:
    """The axes along which each level may cut, 1 for lines between scanlines and 0 for lines between columns.

    ``hs`` cuts between scanlines alone. ``rs`` does so for the first half of the levels, of which it has one more where
    they are odd, and then cuts between columns. ``rrs`` may do both.

    Source: Kurc 1997, sections 6.1.1 to 6.1.3.
    """
    bands = (levels + 1) // 2
    return {"hs": [(_Y,)] * levels, "rs": [(_Y,)] * bands + [(_X,)] * (levels - bands),
            "rrs": [(_Y, _X)] * levels}[splitter]


def can_be_cut(width, height, axes: list[tuple[int, ...]]):
    """Whether regions of these pixels have a cut left for each level: arrays, or numbers."""
    wide, high = (np.frexp(np.maximum(side, 0.25))[1] - 1 for side in (width, height))
    fixed = [sum(each == (axis,) for each in axes) for axis in (_X, _Y)]
    return (wide >= fixed[_X]) & (high >= fixed[_Y]) & (wide + high >= len(axes))


def cut_boxes(boxes: np.ndarray, weights: WorkWeights, axes: list[tuple[int, ...]], width: int,
              height: int) -> list[np.ndarray]:
    """The regions after each level: 1, 2, 4 and so on x 4 int64, as first x, first y, last x and last y.

    A cut has the least load of the heavier side, of all lines along which the level may cut; of equal ones it is the
    first, between scanlines before between columns. Spans and pixels count as boxes of one scanline and of one pixel.

    Parameters
    ----------
    boxes
        N x 4 int64.
    weights
        Of a box, of its spans, and of its pixels.
    axes
        Of each level, see `axes_of`.
    width, height
        Pixels of the screen.

    Raises
    ------
    InputError
        The screen has not enough lines for the levels.

    Source: Kurc 1997, sections 6.1.1 to 6.1.3 and 6.4.
    """
    regions, inside = np.array([[0, 0, width - 1, height - 1]]), [np.asarray(boxes)]
    if not can_be_cut(width, height, axes):
        raise InputError(f"volume: Nodes must be at most those that {width} x {height} pixels can be cut for, "
                         f"not {1 << len(axes)}", parameter="nodes")
    found = [regions]
    for level, allowed in enumerate(axes):
        halves, parts = [], []
        for region, own in zip(regions, inside, strict=True):
            axis, at = min((_best_cut(own, region, axis, weights, axes[level + 1:]) for axis in allowed),
                           key=lambda cut: cut[0])[1:]
            low, high = region.copy(), region.copy()
            low[axis + 2], high[axis] = at, at + 1
            halves += [low, high]
            parts += [_clipped(own[own[:, axis] <= at], axis + 2, partial(np.minimum, at)),
                      _clipped(own[own[:, axis + 2] > at], axis, partial(np.maximum, at + 1))]
        regions, inside = np.array(halves), parts
        found.append(regions)
    return found


def _clipped(boxes, column, limit):
    boxes = boxes.copy()
    boxes[:, column] = limit(boxes[:, column])
    return boxes


def _best_cut(boxes, region, axis, weights, later):
    """Load of the heavier side, axis, and last line of the lower side of the best cut along an axis."""
    first, size = region[axis], region[axis + 2] - region[axis] + 1
    across = boxes[:, 3 - axis] - boxes[:, 1 - axis] + 1
    start, end = boxes[:, axis] - first, boxes[:, axis + 2] - first
    # Spans lie within a scanline: boxes that a cut between columns meets, lines between scanlines.
    whole = weights.triangle + weights.span * across * (axis == _X)
    line = weights.pixel * across + weights.span * (axis == _Y)
    starts, ends = (np.bincount(at, whole, size) for at in (start, end))
    lines = np.cumsum(np.bincount(start, line, size + 1)[:size] - np.bincount(end + 1, line, size + 1)[:size])
    low = np.cumsum(starts + lines)[:-1]
    high = np.cumsum((ends + lines)[::-1])[::-1][1:]
    sides = np.arange(1, size), np.arange(size - 1, 0, -1)
    other = region[3 - axis] - region[1 - axis] + 1
    is_left = np.ones(size - 1, dtype=bool)
    for side in sides:
        is_left &= can_be_cut(*((side, other) if axis == _X else (other, side)), later)
    worst = np.where(is_left, np.maximum(low, high), np.inf)
    if not len(worst):
        return np.inf, axis, first
    at = int(np.argmin(worst))
    return worst[at], axis, first + at
