from functools import partial

import numpy as np

from golden.engine.icu.ipbb import ImagePlaneWindows
from golden.engine.icu.sbb import SphericalWindows
from golden.engine.icu.vertex_direction import vertex_direction
from golden.engine.stimulus import stimulus
from golden.engine.stimulus.frusta import random_hemisphere, random_screen
from hw.icu.spherical_coordinates import SphericalCoordinates
from tb.icu.vectors import rows, vertex_key
from tb.lib.bench import Bench, Case, Vectors

# The low bits of what a CORDIC turns seldom decide.
FEW, MANY = 400, 4000


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
        inputs={"i": [{**vertex_key(k), "direction": vertex} for k, vertex in enumerate(rows(direction))]},
        expected={"o": [{**vertex_key(k), "first": int(first[k]), "second": int(second[k]),
                         "front": int(direction[k, 2] > 0)} for k in range(count)]})


class TestSphericalCoordinates(Bench):
    component = SphericalCoordinates
    cases = {"few": Case(partial(of_record, random_hemisphere, FEW), simulated=False),
             "many": Case(partial(of_record, random_hemisphere, MANY), []),
             "screen": partial(of_record, random_screen, FEW)}
