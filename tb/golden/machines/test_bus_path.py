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
