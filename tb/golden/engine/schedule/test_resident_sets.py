"""The resident set of each cluster, and local addresses."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from golden.base.errors import InputError
from golden.engine.schedule.resident_sets import ResidentSets, fill_up, resident_sets
from tb.lib.schedules import SETTINGS

PATCHES = np.array([9, 4, 7, 1, 3])
CLUSTER = np.array([1, 0, 1, 1, 0])
FREQUENCY = np.array([5, 2, 8, 1, 2])


def test_each_cluster_holds_its_patches_in_the_order_of_discovery():
    sets = resident_sets(PATCHES, CLUSTER, FREQUENCY, clusters=4)
    assert [held.tolist() for held in sets.patches] == [[4, 3], [9, 7, 1], [], []]
    assert len(sets) == 5
    assert sets.chosen.tolist() == [4, 3, 9, 7, 1]


def test_the_most_used_patches_stay_when_the_capacity_is_exceeded():
    sets = resident_sets(PATCHES, CLUSTER, FREQUENCY, clusters=2, capacity=2)
    assert [held.tolist() for held in sets.patches] == [[4, 3], [9, 7]]
    assert len(resident_sets(PATCHES, CLUSTER, FREQUENCY, clusters=2, capacity=0)) == 0


def test_residence_names_cluster_and_local_address_or_nothing():
    cluster, address = resident_sets(PATCHES, CLUSTER, FREQUENCY, clusters=2, capacity=2).residence(11)
    assert cluster.tolist() == [-1, -1, -1, 0, 0, -1, -1, 1, -1, 1, -1]
    assert address.tolist() == [-1, -1, -1, 1, 0, -1, -1, 1, -1, 0, -1]


def test_negative_capacity_is_refused():
    with pytest.raises(InputError, match="Capacity must be at least 0, not -1"):
        resident_sets(PATCHES, CLUSTER, FREQUENCY, clusters=2, capacity=-1)


@settings(SETTINGS, max_examples=60)
@given(held=st.lists(st.integers(0, 3), min_size=1, max_size=4), capacity=st.integers(0, 4), data=st.data())
def test_patches_are_added_at_home_and_then_where_most_entries_are_free(held, capacity, data):
    """Clusters that are full, empty or beyond the capacity, one patch after the other."""
    starts = np.cumsum([0, *held])
    sets = ResidentSets(tuple(np.arange(*ends) for ends in pairwise(starts)))
    homes = data.draw(st.lists(st.integers(-1, len(held) - 1), max_size=9))
    patches = 100 + np.arange(len(homes))
    chosen, free = {}, [max(0, capacity - count) for count in held]
    for is_home in (True, False):
        for patch, home in zip(patches.tolist(), homes, strict=True):
            where = home if is_home else int(np.argmax(free))
            if patch not in chosen and where >= 0 and free[where] > 0:
                chosen[patch] = where
                free[where] -= 1
    found = fill_up(sets, patches, np.array(homes, dtype=int), capacity=capacity)
    assert [part.tolist() for part in found.patches] == [
        [*sets.patches[number].tolist(), *(patch for patch in sorted(chosen) if chosen[patch] == number)]
        for number in range(len(held))]
