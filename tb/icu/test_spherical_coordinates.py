import numpy as np
import pytest

from golden.icu.ipbb import ImagePlaneWindows
from golden.icu.sbb import SphericalWindows
from golden.icu.vertex_direction import vertex_direction
from golden.stimulus import stimulus
from golden.stimulus.frusta import random_hemisphere, random_screen
from hw.icu.spherical_coordinates import SphericalCoordinates
from tb.icu.vectors import rows, vertex_place
from tb.lib.block_bench import Vectors, check_block, check_in_simulator
from tb.lib.runner import SIMULATORS

# The low bits of what a CORDIC turns seldom decide.
FEW, MANY = 400, 4000


def make(config):
    return SphericalCoordinates(config=config)


def vectors(config):
    return of_record(random_hemisphere, FEW, config)


def many_vectors(config):
    return of_record(random_hemisphere, MANY, config)


def screen_vectors(config):
    return of_record(random_screen, FEW, config)


def directions(count, config):
    """V' by turns: drawn, with components of sizes of their own, and nearly as long as can be."""
    random, vector = np.random.default_rng(2), config.numbers.vector
    each = -(-count // 3)
    drawn = stimulus("icu.vertex_direction", count=each, seed=3, config=config).arrays["direction"]
    part = random.choice([-1, 1], (2, each, 3)) * random.uniform(0.875, 1, (2, each, 3))
    part[0] *= 2.0 ** random.uniform(-vector.width, 0, (each, 3))
    uneven, long = vertex_direction(np.rint(part * vector.high).astype(np.int64), config.numbers)[0]
    return np.stack([drawn, uneven, long], axis=1).reshape(-1, 3)[:count]


def of_record(frustum, count, config):
    direction = directions(count, config)
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
                         "front": int(direction[k, 2] > 0)} for k in range(count)]})


def test_every_width_and_depth():
    check_block(make, vectors)
    check_block(make, screen_vectors)


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    check_in_simulator("spherical_coordinates", make, many_vectors, screen_vectors, simulator=simulator)
