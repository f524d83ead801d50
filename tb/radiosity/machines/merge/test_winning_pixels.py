"""The modified scanline z-buffer has the winners of a plain one, in order, without clearing anything."""

import numpy as np
import pytest

from radiosity.machines.merge.span_lists import span_lists
from radiosity.machines.merge.winning_pixels import pixels_of_spans
from tb.radiosity.machines.merge.drawn import drawn_triangles, plain_picture, spans_of

pytestmark = pytest.mark.usefixtures("interpreted")

WIDTH, HEIGHT = 40, 30


@pytest.mark.parametrize("seed", range(6))
def test_winners_are_those_of_a_plain_z_buffer(seed):
    spans = span_lists(*_dealt(seed), WIDTH, HEIGHT)
    pixels = pixels_of_spans(spans, 3, WIDTH)
    for node in range(3):
        own = type(spans)(*(each[spans.node == node] for each in spans))
        picture, is_active = plain_picture(own, WIDTH, HEIGHT)
        part = slice(pixels.start[node], pixels.start[node + 1])
        assert np.array_equal(pixels.location[part], np.flatnonzero(is_active))
        shade = picture.reshape(-1, 3)[pixels.location[part]].astype(np.int64) @ [1 << 16, 256, 1]
        assert np.array_equal(pixels.shade[part], shade)


def _dealt(seed):
    triangles, number = drawn_triangles(seed, 60, width=WIDTH, height=HEIGHT)
    return triangles, number % 3


def test_an_index_of_an_earlier_line_is_not_compared_with():
    """The far span on the second line wins: the near one is on the first."""
    pixels = pixels_of_spans(spans_of([(0, 0, 2, 6), (0, 1, 2, 6)]), 1, 10)
    assert pixels.location.tolist() == [*range(2, 7), *range(12, 17)]
    assert pixels.depth.tolist() == [0] * 5 + [1] * 5


def test_the_part_beyond_earlier_spans_is_appended_and_the_rest_compared():
    pixels = pixels_of_spans(spans_of([(0, 0, 0, 3), (0, 0, 2, 5), (0, 0, 3, 4)]), 1, 10)
    assert pixels.location.tolist() == list(range(6))
    assert pixels.depth.tolist() == [0, 0, 0, 0, 1, 1]


def test_of_two_pixels_at_one_depth_the_lower_shade_wins_in_any_order():
    slope = np.zeros((2, 8))
    slope[:, 3] = 9, 4
    for order in ([0, 1], [1, 0]):
        pixels = pixels_of_spans(spans_of([(0, 0, 1, 1), (0, 0, 1, 1)], slope=slope[order]), 1, 4)
        assert pixels.shade.tolist() == [4]


def test_nodes_without_pixels_have_none():
    pixels = pixels_of_spans(spans_of([(2, 0, 1, 1)]), 4, 4)
    assert pixels.start.tolist() == [0, 0, 0, 1, 1]
