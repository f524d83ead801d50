"""Grades of the paper's figures."""

import pytest

from radiosity.benchmarks.paper_machine import grade_effectiveness, grade_gain, grade_misses, nearest_power

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
