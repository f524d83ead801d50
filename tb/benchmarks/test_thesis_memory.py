"""Requests by memory, and grades of the thesis' figures 6.5 and 6.6."""

import numpy as np
import pytest

from benchmarks.thesis_memory import by_memory, grade_growth, grade_share, in_turn
from golden.engine.memsys.bus.cache import Cache
from golden.engine.memsys.bus.cache_policy import CachePolicy

pytestmark = pytest.mark.xdist_group("machines")


def test_clusters_request_in_turn():
    assert in_turn([[4, 5, 6], [], [7]]) == [(0, 4), (2, 7), (0, 5), (0, 6)]


def test_each_memory_serves_its_requests():
    cache, home = Cache(CachePolicy.LFU, lines=4), np.array([0, 1, -1, -1])
    assert by_memory([[0, 1, 2], [2, 3]], home, cache) == (1, 1, 1, 2)
    assert by_memory([[2, 3], []], home, cache) == (0, 0, 2, 0)


@pytest.mark.parametrize(("many", "few", "expected"), [
    (110, 100, "reproduced"), (130, 100, "not reproduced"), (0, 0, "reproduced")])
def test_grades_of_growth(many, few, expected):
    assert grade_growth(many, few) == expected


@pytest.mark.parametrize(("share", "before", "expected"), [
    (0.6, 0.1, "reproduced"), (0.3, 0.1, "same shape"), (0.1, 0.3, "not reproduced")])
def test_grades_of_a_share(share, before, expected):
    assert grade_share(share, before) == expected
