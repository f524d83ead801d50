"""Cycles that were worked out by hand."""

import pytest

from tb.lib.stages import Elastic, Expand, Gate, Gather, Rigid, passage


@pytest.mark.parametrize(("stages", "offered", "stalled", "accepted", "left"), [
    ([], [1, 2], {2}, [1, 3], [1, 3]),
    # Two are inside while the output stalls; the third one enters when the first one has left.
    ([Elastic(1, 2)], [1, 2, 3, 4], {2, 3, 4, 5}, [1, 2, 7, 8], [6, 7, 8, 9]),
    ([Elastic(0, 1)], [1, 2], {1}, [1, 3], [2, 3]),
    ([Elastic(3)], [1, 2], set(), [1, 2], [4, 5]),
    ([Elastic([5, 1], 1)], [1, 2], set(), [1, 7], [6, 8]),
    ([Elastic(1, interval=4)], [1, 2], set(), [1, 5], [2, 6]),
    # The empty register between both items stalls too.
    ([Rigid(2)], [1, 3], {3, 4}, [1, 5], [5, 7]),
    ([Rigid(1)], [1, 1], set(), [1, 2], [2, 3]),
    ([Expand([2, 0, 1])], [1, 2, 3], set(), [1, 3, 4], [1, 2, 4]),
    ([Expand([2, 1], holds=True)], [1, 2], {2}, [3, 4], [1, 3, 4]),
    ([Gather(2)], [1, 2, 5, 6], set(), [1, 2, 5, 6], [2, 6]),
    ([Gather([1, 2])], [1, 2, 5], {5}, [1, 2, 6], [1, 6]),
    ([Gate([0, 9])], [1, 2], set(), [1, 9], [1, 9]),
    # A pipeline in front of a skid buffer: both buffer entries fill before the pipeline stalls.
    ([Rigid(1), Elastic(1, 2)], [1, 2, 3, 4], {3, 4, 5, 6}, [1, 2, 3, 8], [7, 8, 9, 10])])
def test_cycles_by_hand(stages, offered, stalled, accepted, left):
    assert passage(stages, offered, stalled) == (accepted, left)
