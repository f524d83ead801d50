from functools import partial

import numpy as np
import pytest

from golden.engine.icu.ipbb import ImagePlaneWindows
from golden.engine.stimulus.frusta import frustum_record, random_screen
from hw.icu.ipbb import Ipbb
from tb.icu.shadow_frustum import random_shadow
from tb.icu.vectors import (
    LIMITS,
    SHADOWS,
    assert_all_occur,
    frustum_of,
    largest,
    rows,
    seen_through,
    slot_of,
    winding_of,
    window_of,
)
from tb.lib.bench import Bench, Case, Vectors
from tb.lib.configurations import CONFIGURATIONS, config_of

COUNT = 300


def small_frustum(config):
    return seen_through(random_screen(np.random.default_rng(6), config), "icu.ipbb", count=COUNT, seed=6, config=config)


def shadow_frustum(config):
    record = random_shadow(np.random.default_rng(8), config, bits=6)
    return seen_through(record, "icu.ipbb", count=COUNT, seed=8, config=config)


def largest_frustum(config):
    record = random_screen(np.random.default_rng(7), config, largest(config))
    return seen_through(record, "icu.ipbb", count=COUNT, seed=7, config=config)


def long_frustum(config):
    """Its grid has far more columns than the frustum."""
    record = random_screen(np.random.default_rng(10), config, (3, 1 << config.icu.side_bits))
    return seen_through(record, "icu.ipbb", count=COUNT, seed=10, config=config)


def vectors(draw, config):
    given = draw(config)
    windows, direction = ImagePlaneWindows(frustum_record(given, config), config), given["direction"]
    first, second = (windows.quotients(direction[..., axis], direction[..., 2]) for axis in range(2))
    signs = rows(np.sign(given["planes"][:, :5]))
    front = ((direction[..., 2] > 0) << np.arange(4)).sum(axis=1)
    return Vectors(
        ports={"frustum": frustum_of(given, config)},
        inputs={"i": [{**slot_of(k), "first": rows(first[k]), "second": rows(second[k]), "front": int(front[k]),
                       "winding": winding_of(given, k), "signs": signs[k]} for k in range(COUNT)]},
        expected={"o": [{**slot_of(k), "window": window_of(given, k)} for k in range(COUNT)]})


class TestIpbb(Bench):
    component = Ipbb
    cases = {"small frustum": Case(partial(vectors, small_frustum), [*CONFIGURATIONS.values(), {"icu.side_bits": 16}]),
             "small frustum beside shadows": Case(partial(vectors, small_frustum), SHADOWS, simulated=False),
             "shadow frustum": Case(partial(vectors, shadow_frustum), SHADOWS, simulated=False),
             "long frustum": Case(partial(vectors, long_frustum), LIMITS),
             # Only the finest grid has many entries at the very border of a window.
             "largest frustum": Case(partial(vectors, largest_frustum), [*LIMITS, {"icu.side_bits": 16}])}


@pytest.mark.parametrize("given", [small_frustum, largest_frustum])
def test_the_vectors_hold_every_case(given):
    given = given(config_of({}))
    behind = (given["direction"][..., 2] <= 0).sum(axis=1)
    rays = given["column_count"] > 0
    assert_all_occur({
        "in front": rays & (behind == 0), "partly behind the eye": rays & (behind > 0), "behind the eye": behind == 4,
        "over the whole width": given["column_count"] == given["frustum_columns"],
        "in the middle of the screen": rays & (given["column_count"] < given["frustum_columns"]),
        "beside the screen": ~rays & (behind == 0), "split": given["split"],
        "edge-on in front": (behind == 0) & ~given["orientation"].any(axis=1)})
