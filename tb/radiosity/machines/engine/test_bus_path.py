"""When patches of main memory come over the bus, by hand and by queues without bounds."""

from dataclasses import replace

import numpy as np
import pytest

from golden.engine.config import PRESETS
from radiosity.machines.engine.bus_path import BusTiming, bus_cycle, bus_path, request_on_bus
from tb.radiosity.machines.engine.simpy_joint import SimpyBus

pytestmark = pytest.mark.usefixtures("interpreted")

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


@pytest.mark.parametrize("seed", range(6))
def test_grants_and_answers_are_those_of_unbounded_queues_however_often_buffers_wrap(seed):
    """Three requests of each cluster wait at most, in a buffer of three; four answers and two fetches are in flight."""
    rng = np.random.default_rng(seed)
    memsys = PRESETS["paper"].replace({"memsys.cache_policy": "lru", "memsys.patch_lines": 8}).memsys
    timing = BusTiming(request=2, hit=3, fetch=20, next_fetch=5, words=4, beats=2, outstanding=3, fetches=2, requests=4)
    path, queues = bus_path(timing, memsys, clusters=3, kept=[1, 2]), SimpyBus(timing, memsys, 3, [1, 2])
    waiting, granted = [0, 0, 0], 0
    for cycle in range(400):
        for cluster in np.flatnonzero(rng.random(3) < 0.4):
            if waiting[cluster] < 3:
                patch = int(rng.integers(12))
                request_on_bus(path, cycle, cluster, patch)
                queues.ask(int(cluster), patch, cycle + timing.request)
                waiting[cluster] += 1
        found = bus_cycle(path, cycle)
        assert found == (queues.grant(cycle) or (-1, 0))
        if found[0] >= 0:
            waiting[found[0]] -= 1
            granted += 1
    assert granted > 100
