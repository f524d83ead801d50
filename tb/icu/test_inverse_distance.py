import pytest

from golden.stimulus import stimulus
from hw.icu.inverse_distance import InverseDistance
from tb.icu.vectors import rows
from tb.lib.block_bench import Vectors, check_block, check_in_simulator
from tb.lib.runner import SIMULATORS


def make(config):
    return InverseDistance(config=config, tag=9)


def vectors(config):
    given = stimulus("icu.inverse_distance", count=400, seed=3, config=config).arrays
    return Vectors(
        items=[{"tag": k, "direction": rows(given["ray"][k]), "mantissa": rows(given["mantissa"][k]),
                "exponent": int(given["factor_exponent"][k])} for k in range(400)],
        expected={"o": [{"tag": k, "inverse": int(given["inverse"][k])} for k in range(400)]})


def test_every_width_and_depth():
    check_block(make, vectors)


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    check_in_simulator("inverse_distance", make, vectors, simulator=simulator)
