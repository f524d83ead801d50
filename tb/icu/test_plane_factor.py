import pytest

from golden.stimulus import stimulus
from hw.icu.plane_factor import PlaneFactor
from tb.icu.vectors import factor_of, rows, slot_of
from tb.lib.block_bench import Vectors, check_block, check_in_simulator
from tb.lib.runner import SIMULATORS


def make(config):
    return PlaneFactor(config=config)


def vectors(config):
    given = stimulus("icu.plane_factor", count=200, seed=3, config=config).arrays
    return Vectors(
        items=[{**slot_of(k), "vertices": vertices} for k, vertices in enumerate(rows(given["vertices"]))],
        expected={"o": [{**slot_of(k), "part": factor_of(given, k)} for k in range(200)]})


def test_every_width_and_depth():
    check_block(make, vectors, interval=4)


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    check_in_simulator("plane_factor", make, vectors, simulator=simulator, interval=4)
