"""Cuts are the best of all lines by exact counts, along the axes that each splitter has."""

import numpy as np
import pytest

from golden.base.errors import InputError
from radiosity.machines.merge.box_cuts import axes_of, can_be_cut, cut_boxes
from radiosity.machines.merge.work_weights import TRIANGLES_ALONE, WorkWeights

WIDTH, HEIGHT = 24, 16
WEIGHTS = WorkWeights(triangle=7, span=3, pixel=1)


def drawn(seed, count=60):
    rng = np.random.default_rng(seed)
    low = rng.integers(0, (WIDTH, HEIGHT), (count, 2)) * rng.random((count, 1))
    high = np.minimum(low + rng.integers(0, 8, (count, 2)), (WIDTH - 1, HEIGHT - 1))
    return np.concatenate([low, high], axis=1).astype(np.int64)


def load(boxes, weights, left, top, right, bottom):
    """Boxes, spans and pixels of a rectangle, one by one."""
    found = 0
    for first_x, first_y, last_x, last_y in boxes:
        wide, high = min(last_x, right) - max(first_x, left) + 1, min(last_y, bottom) - max(first_y, top) + 1
        if wide > 0 and high > 0:
            found += weights.triangle + weights.span * high + weights.pixel * wide * high
    return found


def best_cut(boxes, weights, region, axes):
    """Least load of the heavier side over all lines."""
    left, top, right, bottom = region
    found = []
    if 1 in axes:
        found += [max(load(boxes, weights, left, top, right, y), load(boxes, weights, left, y + 1, right, bottom))
                  for y in range(top, bottom)]
    if 0 in axes:
        found += [max(load(boxes, weights, left, top, x, bottom), load(boxes, weights, x + 1, top, right, bottom))
                  for x in range(left, right)]
    return min(found)


@pytest.mark.parametrize("splitter", ["hs", "rs", "rrs"])
@pytest.mark.parametrize("weights", [TRIANGLES_ALONE, WEIGHTS])
@pytest.mark.parametrize("seed", range(4))
def test_each_cut_is_the_best_by_a_count_of_each_box(splitter, weights, seed):
    boxes, axes = drawn(seed), axes_of(splitter, 2)
    found = cut_boxes(boxes, weights, axes, WIDTH, HEIGHT)
    for level in range(2):
        for region, (low, high) in zip(found[level], found[level + 1].reshape(-1, 2, 4), strict=True):
            assert (low[:2] == region[:2]).all()
            assert (high[2:] == region[2:]).all()
            axis = 1 if low[3] < region[3] else 0
            assert axis in axes[level]
            assert high[axis] == low[axis + 2] + 1
            worst = max(load(boxes, weights, *low), load(boxes, weights, *high))
            if level == 0:
                assert worst == best_cut(boxes, weights, region, axes[level])


def test_splitters_cut_along_their_axes():
    assert axes_of("hs", 3) == [(1,)] * 3
    assert axes_of("rs", 4) == [(1,), (1,), (0,), (0,)]
    assert axes_of("rs", 3) == [(1,), (1,), (0,)]
    assert axes_of("rrs", 2) == [(1, 0)] * 2


@pytest.mark.parametrize("splitter", ["hs", "rs", "rrs"])
@pytest.mark.parametrize("levels", [0, 3, 4])
def test_regions_are_the_screen(splitter, levels):
    """Also where all boxes are in one corner, of which each node still has a part."""
    for boxes in (drawn(9), np.tile([[0, 0, 1, 1]], (40, 1))):
        regions = cut_boxes(boxes, TRIANGLES_ALONE, axes_of(splitter, levels), WIDTH, HEIGHT)[-1]
        owned = np.zeros((HEIGHT, WIDTH), dtype=int)
        for left, top, right, bottom in regions:
            owned[top:bottom + 1, left:right + 1] += 1
        assert len(regions) == 1 << levels
        assert (owned == 1).all()


def test_a_screen_without_enough_lines_is_refused():
    with pytest.raises(InputError, match="Nodes must be at most those that 24 x 16 pixels can be cut for, not 32"):
        cut_boxes(drawn(0), TRIANGLES_ALONE, axes_of("hs", 5), WIDTH, HEIGHT)


def test_lines_are_left_for_later_cuts():
    assert can_be_cut(4, 8, [(1,)] * 3)
    assert not can_be_cut(4, 7, [(1,)] * 3)
    assert can_be_cut(4, 8, [(0, 1)] * 5)
    assert not can_be_cut(4, 8, [(0, 1)] * 6)
    assert can_be_cut(np.array([1, 2, 5]), 1, [(0,)]).tolist() == [False, True, True]
