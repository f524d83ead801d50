"""The order of the queue: neighbours follow each other, and the end is even."""

import heapq

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from golden.engine.jobs.order import TAIL, long_and_short, longest_first_at_the_end, proximity_order
from tb.lib.schedules import SETTINGS

POINTS = st.lists(st.tuples(*[st.integers(0, 1 << 24)] * 3), max_size=30)


@SETTINGS
@given(POINTS)
def test_each_frustum_follows_once_and_none_left_is_nearer(points):
    points = np.array(points, dtype=np.int64).reshape(-1, 3)
    order = proximity_order(points)
    assert sorted(order.tolist()) == list(range(len(points)))
    for index in range(1, len(order)):
        away = np.square((points - points[order[index - 1]]).astype(float)).sum(axis=1)
        assert away[order[index]] == away[order[index:]].min()


def test_a_line_is_followed_from_an_end_and_equals_by_their_numbers():
    line = np.zeros((9, 3), dtype=np.int64)
    line[:, 1] = [5, 2, 8, 0, 1, 2, 9, 3, 4]
    order = proximity_order(line)
    assert line[order, 1].tolist() in ([0, 1, 2, 2, 3, 4, 5, 8, 9], [9, 8, 5, 4, 3, 2, 2, 1, 0])
    assert order.tolist().index(1) < order.tolist().index(5)


@pytest.mark.parametrize("clusters", [1, 3])
@SETTINGS
@given(st.lists(st.integers(1, 9), max_size=20))
def test_the_end_falls_and_the_rest_stays(clusters, cycles):
    order = longest_first_at_the_end(cycles, clusters=clusters)
    assert sorted(order.tolist()) == list(range(len(cycles)))
    kept = max(0, len(cycles) - TAIL * clusters)
    assert order[:kept].tolist() == list(range(kept))
    tail = [(-cycles[number], number) for number in order[kept:]]
    assert tail == sorted(tail)


def longest_cluster(cycles, clusters):
    """When the last cluster ends, if the first free one takes the next section."""
    free = [0.0] * clusters
    for one in cycles:
        heapq.heapreplace(free, free[0] + one)
    return max(free)


def test_a_job_of_247_frusta_ends_evenly_on_16_clusters():
    random = np.random.default_rng(0)
    before, after = [], []
    for _ in range(50):
        cycles = random.normal(1, 0.15, 247).clip(0.3)
        before.append(cycles.sum() / longest_cluster(cycles, 16))
        after.append(cycles.sum() / longest_cluster(cycles[longest_first_at_the_end(cycles, clusters=16)], 16))
    assert np.mean(after) > np.mean(before) + 0.1
    assert min(after) > 15


@SETTINGS
@given(st.lists(st.integers(1, 9), max_size=20))
def test_long_and_short_sections_alternate_and_both_fall(cycles):
    order = long_and_short(cycles)
    assert sorted(order.tolist()) == list(range(len(cycles)))
    lengths = [cycles[number] for number in order]
    assert lengths[0::2] + lengths[1::2] == sorted(cycles, reverse=True)
