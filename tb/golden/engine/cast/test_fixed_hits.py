"""Hits of two casts are the same only in all their fields."""

from dataclasses import fields, replace

import numpy as np
import pytest

from golden.engine.cast.fixed_hits import FixedHits

NAMES = [field.name for field in fields(FixedHits)]
HITS = FixedHits(inverse=np.array([5, 0, 9, 4]), patch=np.array([7, -1, 0, 7]), u=np.array([1, 0, 2, 3]),
                 v=np.array([3, 0, 2, 1]))


def test_there_is_no_difference_from_a_copy():
    copy = FixedHits(**{name: getattr(HITS, name).copy() for name in NAMES})
    assert HITS.differences(copy).tolist() == copy.differences(HITS).tolist() == []


@pytest.mark.parametrize("name", NAMES)
def test_a_ray_differs_if_any_field_does(name):
    for changed in ([2], [0, 3], [0, 1, 2, 3]):
        values = getattr(HITS, name).copy()
        values[changed] += 1
        other = replace(HITS, **{name: values})
        assert HITS.differences(other).tolist() == other.differences(HITS).tolist() == changed
