import numpy as np
import pytest

from golden.icu.inverse_distance import SMALLEST, inverse_distance
from golden.stimulus import stimulus
from golden.stimulus.icu.plane_factor import factor_of
from hw.icu.inverse_distance import InverseDistance
from tb.icu.vectors import assert_all_occur, rows
from tb.lib.block_bench import Vectors, check_block, check_in_simulator
from tb.lib.configurations import CONFIGURATIONS, config_of
from tb.lib.runner import SIMULATORS

COUNT = 400


def make(config):
    return InverseDistance(config=config, tag=9)


def drawn(config):
    return stimulus("icu.inverse_distance", count=COUNT, seed=3, config=config).arrays


def along_the_planes(config):
    """Planes across an axis, and rays that lie in them or all but do."""
    given, number = drawn(config), np.arange(COUNT)
    across = number % 3
    given["mantissa"] *= np.arange(3) == across[:, None]
    given["ray"][number, across] = number // 3 % 3 - 1
    return given | {"inverse": inverse_distance(factor_of(given), given["ray"], config.numbers)}


def vectors(config):
    return of(drawn(config))


def plane_vectors(config):
    return of(along_the_planes(config))


def of(given):
    return Vectors(
        items=[{"tag": k, "direction": rows(given["ray"][k]), "mantissa": rows(given["mantissa"][k]),
                "exponent": int(given["factor_exponent"][k])} for k in range(COUNT)],
        expected={"o": [{"tag": k, "inverse": int(given["inverse"][k])} for k in range(COUNT)]})


def test_every_width_and_depth():
    check_block(make, vectors)
    check_block(make, plane_vectors)


@pytest.mark.parametrize("changes", CONFIGURATIONS.values(), ids=CONFIGURATIONS)
def test_the_vectors_hold_every_case(changes):
    config = config_of(changes)
    inverse, high = drawn(config)["inverse"], config.numbers.inverse.high
    beside = along_the_planes(config)
    side = np.sign(np.einsum("ki,ki->k", beside["mantissa"], beside["ray"]))
    assert_all_occur({"farthest": inverse == SMALLEST, "nearest": inverse == high,
                      "between": (inverse > SMALLEST) & (inverse < high),
                      **{f"in a plane or beside it, {sign}": side == sign for sign in (-1, 0, 1)}})


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    check_in_simulator("inverse_distance", make, vectors, plane_vectors, simulator=simulator)
