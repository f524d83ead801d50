import pytest

from golden.icu.settle_code import settle_threshold
from golden.stimulus import stimulus
from golden.stimulus.frusta import frustum_record
from hw.icu.inverse_distance_bound import InverseDistanceBound
from tb.icu.frustum_load import table_writes
from tb.icu.vectors import factor_of, frustum_of, slot_of, window_of
from tb.lib.block_bench import Vectors, check_block, check_in_simulator
from tb.lib.runner import SIMULATORS


def make(config):
    return InverseDistanceBound(config=config)


def vectors(config):
    return of_seed(2, config)


def other_vectors(config):
    return of_seed(3, config)


def of_seed(seed, config):
    given = stimulus("icu.patch_setup", count=160, seed=seed, config=config).arrays
    threshold = settle_threshold(given["bound"], config)
    return Vectors(
        ports={"frustum": frustum_of(given, config)}, tables=table_writes(frustum_record(given, config), config),
        items=[{**slot_of(k), "factor": factor_of(given, k), "window": window_of(given, k)} for k in range(160)],
        expected={"o": [{**slot_of(k), "bound": int(given["bound"][k]), "threshold": int(threshold[k])}
                        for k in range(160)]})


def test_every_width_and_depth():
    check_block(make, vectors, interval=4)
    check_block(make, other_vectors, interval=4)


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    check_in_simulator("inverse_distance_bound", make, vectors, simulator=simulator, interval=4)
