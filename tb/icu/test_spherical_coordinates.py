import numpy as np
import pytest

from golden.icu.ipbb import ImagePlaneWindows
from golden.icu.sbb import SphericalWindows
from golden.stimulus import stimulus
from golden.stimulus.frusta import random_hemisphere, random_screen
from hw.icu.spherical_coordinates import SphericalCoordinates
from tb.icu.vectors import rows, vertex_place
from tb.lib.block_bench import Vectors, check_block, check_in_simulator
from tb.lib.runner import SIMULATORS


def make(config):
    return SphericalCoordinates(config=config)


def vectors(config):
    return of_record(random_hemisphere, config)


def screen_vectors(config):
    return of_record(random_screen, config)


def of_record(frustum, config):
    direction = stimulus("icu.vertex_direction", count=400, seed=3, config=config).arrays["direction"]
    record = frustum(np.random.default_rng(1), config)
    if record.is_screen:
        windows = ImagePlaneWindows(record, config)
        first, second = (windows.quotients(direction[:, axis], direction[:, 2]) for axis in range(2))
    else:
        first, second = SphericalWindows(record, config).angles(direction)
    return Vectors(
        ports={"is_screen": int(record.is_screen)},
        items=[{**vertex_place(k), "direction": vertex} for k, vertex in enumerate(rows(direction))],
        expected={"o": [{**vertex_place(k), "first": int(first[k]), "second": int(second[k]),
                         "front": int(direction[k, 2] > 0)} for k in range(400)]})


def test_every_width_and_depth():
    check_block(make, vectors)
    check_block(make, screen_vectors)


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    check_in_simulator("spherical_coordinates", make, vectors, simulator=simulator)
