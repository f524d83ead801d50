import random

import numpy as np
import pytest

from golden.icu.sbb import SphericalWindows
from golden.stimulus.frusta import frustum_record, random_hemisphere
from hw.icu.sbb import Sbb
from tb.icu.frustum_load import table_writes
from tb.icu.vectors import (
    LIMITS,
    assert_all_occur,
    frustum_of,
    largest,
    rows,
    seen_through,
    slot_of,
    turns_of,
    window_of,
)
from tb.lib.block_bench import Vectors, check_block, check_in_simulator
from tb.lib.configurations import CONFIGURATIONS, config_of
from tb.lib.runner import SIMULATORS

COUNT = 200


def make(config):
    return Sbb(config=config)


def small_frustum(config):
    return seen_through(random_hemisphere(np.random.default_rng(3), config), "icu.sbb", count=COUNT, seed=3,
                        config=config)


def largest_frustum(config):
    record = random_hemisphere(np.random.default_rng(4), config, largest(config))
    return seen_through(record, "icu.sbb", count=COUNT, seed=4, config=config)


def vectors(given, config):
    record = frustum_record(given, config)
    windows, direction = SphericalWindows(record, config), given["direction"]
    first, second = windows.angles(direction)
    signs = rows(np.sign(given["planes"][:, :5]))
    front = ((direction[..., 2] > 0) << np.arange(4)).sum(axis=1)
    tables = table_writes(record, config)
    random.Random(1).shuffle(tables)
    return Vectors(
        ports={"frustum": frustum_of(given, config)}, tables=tables,
        items=[{**slot_of(k), "first": rows(first[k]), "second": rows(second[k]), "front": int(front[k]),
                "turns": turns_of(given, k), "signs": signs[k]} for k in range(COUNT)],
        expected={"o": [{**slot_of(k), "window": window_of(given, k)} for k in range(COUNT)]})


def of_small_frustum(config):
    return vectors(small_frustum(config), config)


def of_largest_frustum(config):
    return vectors(largest_frustum(config), config)


def test_every_width():
    check_block(make, of_small_frustum, interval=4, variants=[*CONFIGURATIONS.values(), {"icu.side_bits": 16}])


def test_the_largest_frustum():
    # Only coarse angles often lie at the very border of a window.
    check_block(make, of_largest_frustum, interval=4, variants=[*LIMITS, {"icu.angle_bits": 18}])


@pytest.mark.parametrize("given", [small_frustum, largest_frustum])
def test_the_vectors_hold_every_case(given):
    given = given(config_of({}))
    first, count, columns = given["column_first"], given["column_count"], given["frustum_columns"]
    assert_all_occur({
        "a part of the ring": (count > 0) & (count < columns), "the whole ring": count == columns,
        "over azimuth 0": first + count > columns, "around the pole": (count == columns) & (given["row_first"] == 0),
        "without rays": count == 0, "split": given["split"], "edge-on": ~given["orientation"].any(axis=1),
        "down to the horizon": given["row_first"] + given["row_count"] == given["frustum_rows"]})


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    check_in_simulator("sbb", make, of_small_frustum, simulator=simulator, interval=4)
