"""Grades of the paper's figures."""

import numpy as np
import pytest

from benchmarks import paper_machine
from benchmarks.paper_machine import _Strings, grade_effectiveness, grade_gain, grade_misses, nearest_power
from golden.engine.config import PRESETS
from golden.engine.memsys.bus.cache_policy import CachePolicy

pytestmark = pytest.mark.xdist_group("machines")


@pytest.mark.parametrize(("gain", "expected"), [
    (0.05, "reproduced"), (0.30, "reproduced"), (0.31, "same shape"), (0.04, "same shape"), (0.01, "not reproduced"),
    (-0.2, "not reproduced")])
def test_a_gain_is_that_of_the_paper_from_5_to_30_percent(gain, expected):
    assert grade_gain(gain) == expected


@pytest.mark.parametrize(("value", "sparser", "denser", "expected"), [
    (0.7, 0.9, 0.1, "reproduced"), (0.8, 0.5, 0.9, "reproduced"), (0.9, 0.8, 0.95, "same shape"),
    (0.9, 0.9, 0.95, "not reproduced"), (0.6, 0.7, 0.5, "not reproduced")])
def test_effectiveness_falls_with_fewer_rays(value, sparser, denser, expected):
    assert grade_effectiveness(value, sparser=sparser, denser=denser) == expected


@pytest.mark.parametrize(("direct", "lfu", "expected"), [
    ((0.9, 0.5, 0.1), (0.8, 0.4, 0.1), "reproduced"), ((0.9, 0.5, 0.1), (0.8, 0.4, 0.2), "same shape"),
    ((0.9, 0.5, 0.1), (0.8, 0.6, 0.2), "not reproduced"), ((0.9, 0.1), (0.9, 0.1), "not reproduced")])
def test_lfu_misses_less(direct, lfu, expected):
    assert grade_misses(direct, lfu) == expected


@pytest.mark.parametrize(("value", "expected"), [(0.4, 1), (1, 1), (90, 64), (91, 128), (331, 256), (100, 128)])
def test_the_nearest_power_is_by_ratio(value, expected):
    assert nearest_power(value) == expected


@pytest.fixture(scope="module")
def strings():
    with pytest.MonkeyPatch.context() as patched:
        patched.setattr(paper_machine, "_RAYS", (32, 16))
        yield _Strings("cornell", PRESETS["paper"])


def test_what_sparse_castings_find_serves_its_share_of_the_references(strings):
    """And again: a casting of one ratio leaves nothing behind for the next one."""
    dense = strings.dense.copy()
    once = {ratio: strings.effectiveness(ratio) for ratio in (16, 4)}
    for ratio in (4, 16, 4):
        curve, share = strings.effectiveness(ratio)
        np.testing.assert_array_equal(curve, once[ratio][0])
        found = np.unique(strings._cast(ratio)[0])
        assert share == once[ratio][1] == np.isin(dense, found).mean()
        # E(k) is the share of the most used k patches' references; that of the last k follows from the set alone.
        counts = np.sort(np.bincount(dense))[::-1]
        assert curve[-1] == pytest.approx(np.isin(dense, found).sum() / counts[:len(found)].sum())
    np.testing.assert_array_equal(strings.dense, dense)


def test_misses_are_those_of_a_cold_cache_each_time(strings):
    first = strings.misses(CachePolicy.LFU)
    strings.misses(CachePolicy.DIRECT)
    assert strings.misses(CachePolicy.LFU) == first
    # A cache with a line for each patch misses once for each.
    assert first[-1] == len(np.unique(strings.dense)) / len(strings.dense)
