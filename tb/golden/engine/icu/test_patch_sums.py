"""Sums of a section: a slow sum with a dictionary, and weights that sum to one."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from golden.cast.hemisphere import Hemisphere
from golden.engine.icu.patch_sums import section_sums
from tb.lib.schedules import SETTINGS

RAYS = st.lists(st.tuples(st.integers(-1, 12), st.sampled_from([0, 1, 5, 1 << 40])), max_size=60)


@SETTINGS
@given(RAYS)
def test_sums_are_in_the_order_of_a_dictionary(rays):
    slow = {}
    for patch, weight in rays:
        if patch >= 0 and weight:
            slow[patch] = slow.get(patch, 0) + weight
    patch, weight = np.array(rays, dtype=np.int64).reshape(-1, 2).T
    sums = section_sums(patch, weight)
    assert list(zip(sums.patch.tolist(), sums.sum.tolist(), strict=True)) == list(slow.items())
    assert sums.overflow == next((patch for patch, sum in slow.items() if sum >= 1 << 42), -1)


def test_sums_of_a_closed_scene_are_one_exactly():
    hemisphere = Hemisphere(2048, 64)
    patch = np.random.default_rng(1).integers(0, 9, len(hemisphere))
    sums = section_sums(patch, hemisphere.weights)
    assert int(sums.sum.sum()) == 2**40
    assert sums.sum[sums.patch.tolist().index(3)] == sum(hemisphere.weights[patch == 3].tolist())
