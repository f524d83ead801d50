import numpy as np
import pytest

from golden.icu.ipbb import ImagePlaneWindows
from golden.stimulus import stimulus
from golden.stimulus.frusta import frustum_record
from hw.icu.ipbb import Ipbb
from tb.icu.vectors import frustum_of, rows, slot_of, turns_of, window_of
from tb.lib.block_bench import Vectors, check_block, check_in_simulator
from tb.lib.runner import SIMULATORS


def make(config):
    return Ipbb(config=config)


def vectors(config):
    return of_seed(3, config)


def of_seed(seed, config):
    given = stimulus("icu.ipbb", count=200, seed=seed, config=config).arrays
    record = frustum_record(given, config)
    windows, direction = ImagePlaneWindows(record, config), given["direction"]
    first, second = (windows.quotients(direction[..., axis], direction[..., 2]) for axis in range(2))
    signs = rows(np.sign(given["planes"][:, :5]))
    front = ((direction[..., 2] > 0) << np.arange(4)).sum(axis=1)
    return Vectors(
        ports={"frustum": frustum_of(given, config)},
        items=[{**slot_of(k), "first": rows(first[k]), "second": rows(second[k]), "front": int(front[k]),
                "turns": turns_of(given, k), "signs": signs[k]} for k in range(200)],
        expected={"o": [{**slot_of(k), "window": window_of(given, k)} for k in range(200)]})


def test_every_width_and_depth():
    check_block(make, vectors)


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    check_in_simulator("ipbb", make, vectors, simulator=simulator)
