"""A span reaches from the rounded first to the rounded last intersection of a triangle with a scanline."""

import numpy as np
import pytest

from radiosity.machines.merge.screen_triangles import ScreenTriangles
from radiosity.machines.merge.span_lists import pixel_counts, span_lists
from tb.radiosity.machines.merge.drawn import drawn_triangles

pytestmark = pytest.mark.usefixtures("interpreted")


def one(*corners, colour=((0, 0, 0),) * 3):
    return ScreenTriangles(np.array([corners], dtype=float), np.array([colour], dtype=float), 1)


def rows(spans):
    return np.stack([spans.line, spans.left, spans.right], axis=1).tolist()


def test_both_ends_are_rounded_and_included():
    spans = span_lists(one((0, 0, 0), (4, 0, 0), (0, 4, 0)), np.zeros(1), 10, 10)
    assert rows(spans) == [[0, 0, 4], [1, 0, 3], [2, 0, 2], [3, 0, 1], [4, 0, 0]]
    spans = span_lists(one((1.4, 0.5, 0), (6.6, 0.5, 0), (4, 1.5, 0)), np.zeros(1), 10, 10)
    assert rows(spans) == [[1, 3, 5]]


def test_spans_end_at_the_screen():
    spans = span_lists(one((-9, -9, 0), (30, -9, 0), (-9, 30, 0)), np.zeros(1), 8, 6)
    assert rows(spans) == [[line, 0, 7] for line in range(6)]
    assert len(span_lists(one((20, 0, 0), (24, 0, 0), (20, 4, 0)), np.zeros(1), 8, 6).line) == 0


def test_depth_and_colours_are_linear_along_a_span():
    spans = span_lists(one((0, 0, 1), (8, 0, 3), (0, 8, 5), colour=((0, 8, 16), (80, 8, 0), (0, 8, 0))), np.zeros(1),
                       10, 10)
    for line, slope in zip(spans.line, spans.slope, strict=True):
        assert slope[:4] == pytest.approx((1 + line / 2, 0, 8, 16 - 2 * line))
        if line < 8:
            assert slope[4:] == pytest.approx((1 / 4, 10, 0, -2))


def test_spans_are_sorted_by_node_line_and_first_x_with_the_lines_new_numbers():
    triangles, number = drawn_triangles(3, 200, width=40, height=30)
    line = np.random.default_rng(1).permutation(30)
    spans = span_lists(triangles, number % 4, 40, 30, line)
    keys = list(zip(spans.node, spans.line, spans.left, strict=True))
    assert keys == sorted(keys)
    plain = span_lists(triangles, number % 4, 40, 30)
    renumbered = sorted(zip(plain.node, line[plain.line], plain.left, plain.right, strict=True))
    assert renumbered == sorted(zip(spans.node, spans.line, spans.left, spans.right, strict=True))


def test_generated_pixels_are_those_of_all_spans():
    triangles, number = drawn_triangles(4, 100, width=40, height=30)
    spans = span_lists(triangles, number % 4, 40, 30)
    counts = pixel_counts(spans, 4)
    assert counts.sum() == (spans.right - spans.left + 1).sum()
    assert counts[2] == sum(spans.right[spans.node == 2] - spans.left[spans.node == 2] + 1)
