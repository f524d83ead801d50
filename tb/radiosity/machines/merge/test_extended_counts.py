"""Extended spans count the locations that win, before any pixel is drawn."""

import numpy as np
import pytest

from radiosity.machines.merge.span_lists import extended_counts
from radiosity.machines.merge.winning_pixels import pixels_of_spans
from tb.radiosity.machines.merge.drawn import spans_of

pytestmark = pytest.mark.usefixtures("interpreted")


@pytest.mark.parametrize("seed", range(6))
def test_counts_are_those_of_the_pixels_that_win(seed):
    rng = np.random.default_rng(seed)
    left = rng.integers(0, 40, 80)
    rows = np.stack([rng.integers(0, 3, 80), rng.integers(0, 5, 80), left,
                     np.minimum(left + rng.integers(0, 6, 80), 39)], axis=1)
    spans = spans_of(rows)
    pixels = pixels_of_spans(spans, 3, 40)
    node = np.repeat(np.arange(3), np.diff(pixels.start))
    expected = np.zeros((3, 5), dtype=np.int64)
    np.add.at(expected, (node, pixels.location // 40), 1)
    assert np.array_equal(extended_counts(spans, 3, 5), expected)


def test_all_runs_of_a_line_count_and_spans_that_touch_are_one():
    """The printed algorithm has 4 here: it keeps the last run alone."""
    spans = spans_of([(0, 0, 0, 2), (0, 0, 3, 5), (0, 0, 8, 9), (0, 0, 20, 23), (0, 0, 21, 22)])
    assert extended_counts(spans, 1, 2).tolist() == [[6 + 2 + 4, 0]]
