import numpy as np
import pytest

from golden.stimulus.frusta import random_hemisphere, random_screen
from hw.icu.ray_direction import RayDirection
from tb.icu.frustum_load import table_writes
from tb.icu.vectors import rows
from tb.lib.block_bench import Vectors, check_block, check_in_simulator
from tb.lib.runner import SIMULATORS


def make(config):
    return RayDirection(config=config, tag=9)


def vectors(config):
    return of_record(random_hemisphere, config)


def screen_vectors(config):
    return of_record(random_screen, config)


def of_record(frustum, config):
    random = np.random.default_rng(1)
    record = frustum(random, config)
    column, row = random.integers(record.columns, size=400), random.integers(record.rows, size=400)
    directions = rows(record.directions(column, row))
    return Vectors(
        ports={"is_screen": int(record.is_screen)}, tables=table_writes(record, config),
        items=[{"tag": k, "column": int(column[k]), "row": int(row[k])} for k in range(400)],
        expected={"o": [{"tag": k, "direction": directions[k]} for k in range(400)]})


def test_every_width_and_depth():
    check_block(make, vectors)
    check_block(make, screen_vectors)


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    check_in_simulator("ray_direction", make, vectors, screen_vectors, simulator=simulator)
