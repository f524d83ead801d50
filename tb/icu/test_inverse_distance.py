import pytest

from golden.icu.inverse_distance import SMALLEST
from golden.stimulus import stimulus
from hw.icu.inverse_distance import InverseDistance
from tb.icu.vectors import assert_all_occur, rows
from tb.lib.block_bench import Vectors, check_block, check_in_simulator
from tb.lib.configurations import CONFIGURATIONS, config_of
from tb.lib.runner import SIMULATORS


def make(config):
    return InverseDistance(config=config, tag=9)


def drawn(config):
    return stimulus("icu.inverse_distance", count=400, seed=3, config=config).arrays


def vectors(config):
    given = drawn(config)
    return Vectors(
        items=[{"tag": k, "direction": rows(given["ray"][k]), "mantissa": rows(given["mantissa"][k]),
                "exponent": int(given["factor_exponent"][k])} for k in range(400)],
        expected={"o": [{"tag": k, "inverse": int(given["inverse"][k])} for k in range(400)]})


def test_every_width_and_depth():
    check_block(make, vectors)


@pytest.mark.parametrize("changes", CONFIGURATIONS.values(), ids=CONFIGURATIONS)
def test_the_vectors_hold_every_case(changes):
    config = config_of(changes)
    inverse, high = drawn(config)["inverse"], config.numbers.inverse.high
    assert_all_occur({"farthest": inverse == SMALLEST, "nearest": inverse == high,
                      "between": (inverse > SMALLEST) & (inverse < high)})


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    check_in_simulator("inverse_distance", make, vectors, simulator=simulator)
