"""Sets without a casting: patch after patch in the next cluster."""

import pytest

from golden.engine.schedule.resident_sets import spread_sets


@pytest.mark.parametrize(("patches", "clusters", "capacity", "expected"), [
    (10, 2, 3, [[0, 2, 4], [1, 3, 5]]), (3, 2, 3, [[0, 2], [1]]), (6, 2, 3, [[0, 2, 4], [1, 3, 5]]),
    (7, 4, 1, [[0], [1], [2], [3]]), (5, 1, 9, [[0, 1, 2, 3, 4]]), (5, 2, 0, [[], []])])
def test_patches_are_dealt_until_all_are_full(patches, clusters, capacity, expected):
    sets = spread_sets(patches, clusters=clusters, capacity=capacity)
    assert [held.tolist() for held in sets.patches] == expected
