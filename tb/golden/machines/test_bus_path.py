"""When patches of main memory come over the bus, by hand."""

from dataclasses import replace

import numpy as np
import pytest

from golden.config import PRESETS
from golden.machines.bus_path import BusTiming, bus_cycle, bus_path, request_on_bus

TIMING = BusTiming(request=1, hit=2, fetch=20, next_fetch=10, words=1, beats=1, outstanding=8, fetches=2, requests=8)


@pytest.mark.parametrize(("fetches", "expected"), [
    # Granted in cycles 1 to 5; each fetch beyond those in flight waits for the entry of the oldest one.
    (8, [21, 22, 23, 24, 25]), (3, [21, 22, 23, 31, 32]), (2, [21, 22, 31, 32, 41]), (1, [21, 31, 41, 51, 61])])
def test_a_fetch_beyond_those_in_flight_waits_for_its_entry(fetches, expected):
    path = bus_path(replace(TIMING, fetches=fetches), PRESETS["tiny"].memsys, clusters=1,
                    kept=np.zeros(0, dtype=np.int64))
    for number in range(len(expected)):
        request_on_bus(path, 0, 0, number)
    assert [bus_cycle(path, 1 + number) for number in range(len(expected))] == [(0, ready) for ready in expected]


@pytest.mark.parametrize(("changes", "expected"), [
    # Of hits: one is looked up when the oldest one in flight has been answered; beats follow each other.
    ({}, [13, 14, 15]), ({"requests": 2}, [13, 14, 15]), ({"requests": 1}, [13, 15, 17]), ({"beats": 4}, [13, 17, 21])])
def test_a_request_beyond_those_in_flight_waits_for_its_answer(changes, expected):
    path = bus_path(replace(TIMING, **changes), PRESETS["tiny"].memsys, clusters=1, kept=np.array([5]))
    for _ in expected:
        request_on_bus(path, 10, 0, 5)
    assert [bus_cycle(path, 11 + number) for number in range(len(expected))] == [(0, ready) for ready in expected]


def test_the_request_that_has_waited_longest_is_granted():
    """None before its time, and of several the first cluster's."""
    path = bus_path(TIMING, PRESETS["tiny"].memsys, clusters=3, kept=np.zeros(0, dtype=np.int64))
    for time, cluster in ((0, 2), (1, 1), (1, 0)):
        request_on_bus(path, time, cluster, cluster)
    assert [bus_cycle(path, time)[0] for time in range(5)] == [-1, 2, 0, 1, -1]
