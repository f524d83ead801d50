import numpy as np
import pytest

from golden.icu.sbb import SphericalWindows
from golden.stimulus import stimulus
from golden.stimulus.frusta import frustum_record
from hw.icu.sbb import Sbb
from tb.icu.frustum_load import table_writes
from tb.icu.vectors import frustum_of, rows, slot_of, turns_of, window_of
from tb.lib.block_bench import Vectors, check_block, check_in_simulator
from tb.lib.runner import SIMULATORS


def make(config):
    return Sbb(config=config)


def vectors(config):
    return of_seed(3, config)


def of_seed(seed, config):
    given = stimulus("icu.sbb", count=200, seed=seed, config=config).arrays
    record = frustum_record(given, config)
    windows, direction = SphericalWindows(record, config), given["direction"]
    first, second = windows.angles(direction)
    signs = rows(np.sign(given["planes"][:, :5]))
    front = ((direction[..., 2] > 0) << np.arange(4)).sum(axis=1)
    return Vectors(
        ports={"frustum": frustum_of(given, config)}, tables=table_writes(record, config),
        items=[{**slot_of(k), "first": rows(first[k]), "second": rows(second[k]), "front": int(front[k]),
                "turns": turns_of(given, k), "signs": signs[k]} for k in range(200)],
        expected={"o": [{**slot_of(k), "window": window_of(given, k)} for k in range(200)]})


def test_every_width_and_depth():
    check_block(make, vectors, interval=4)


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    check_in_simulator("sbb", make, vectors, simulator=simulator, interval=4)
