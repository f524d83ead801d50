"""Pots of the benchmark of merged pictures are like the source's."""

import numpy as np
import pytest

from benchmarks.merge import POTS, Pots, matched_pots, pots_of
from radiosity.machines.merge.span_lists import pixel_counts, span_lists
from radiosity.machines.merge.winning_pixels import pixels_of_spans


def test_pots_have_the_pixels_that_they_are_matched_to():
    goal = Pots(count=2, generated=(24_000, 0), winning=(13_000, 0))
    triangles, number, scale = matched_pots(goal, 5)
    assert len(number) == len(triangles.corners)
    screen = triangles._replace(corners=triangles.corners * (400 * scale, 400 * scale, 1) + (200, 200, 0))
    spans = span_lists(screen, np.zeros(len(number)), 400, 400)
    assert len(pixels_of_spans(spans, 1, 400).location) == pytest.approx(13_000, rel=0.03)
    assert pixel_counts(spans, 1)[0] == pytest.approx(24_000, rel=0.1)


def test_pots_are_as_many_as_the_scene_has():
    one, two = (pots_of(count, 0.5, 1)[0].dealt for count in (1, 2))
    assert two == 2 * one
    assert abs(one / 3751 - 1) < 0.1
    assert [pots.count for pots in POTS.values()] == [1, 2, 4, 4, 8, 8]
