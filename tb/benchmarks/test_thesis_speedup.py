"""Grades of the thesis' figures 6.10, 6.12 and 6.13."""

import pytest

from benchmarks.thesis_speedup import Speed, grade_linear, grades_of

pytestmark = pytest.mark.xdist_group("machines")


@pytest.mark.parametrize(("speedup", "before", "expected"), [
    (6.5, 7.0, "reproduced"), (6.0, 5.0, "same shape"), (5.0, 6.0, "not reproduced")])
def test_grades_of_a_linear_speedup(speedup, before, expected):
    assert grade_linear(speedup, before, 8) == expected


def _speed(speedup, efficiency):
    return Speed(cycles=1, speedup=speedup, efficiency=efficiency)


def test_grades_are_those_of_eight_clusters_and_of_each_cache():
    found = {1: [_speed(1.0, 0.9)] * 3, 8: [_speed(4.0, 0.41), _speed(5.0, 0.5), _speed(7.0, 0.8)],
             16: [_speed(9.0, 0.1)] * 3}
    assert [[text for _, text in each] for _, _, each in grades_of(found)] == [
        ["same shape", "reproduced"], ["reproduced", "reproduced"], ["not reproduced", "reproduced"],
        ["same shape", "reproduced"], ["reproduced", "reproduced"]]


def test_a_speedup_that_does_not_fall_off_is_not_reproduced():
    found = {clusters: [_speed(float(clusters), 0.4)] * 3 for clusters in (1, 8, 16)}
    *_, (_, _, fall) = grades_of(found)
    assert [text for _, text in fall] == ["not reproduced"] * 2
