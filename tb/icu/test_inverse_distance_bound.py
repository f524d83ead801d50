import random

import numpy as np
import pytest

from golden.icu.settle_code import settle_threshold
from golden.stimulus import block
from golden.stimulus.frusta import SOURCE, frustum_arrays, frustum_record, random_hemisphere, random_screen
from golden.stimulus.patches import scene_patches
from hw.icu.inverse_distance_bound import InverseDistanceBound
from tb.icu.frustum_load import table_writes
from tb.icu.vectors import LIMITS, assert_all_occur, factor_of, frustum_of, largest, slot_of, window_of
from tb.lib.block_bench import Vectors, check_block, check_in_simulator
from tb.lib.configurations import config_of
from tb.lib.runner import SIMULATORS

COUNT = 160
FRUSTA = (random_hemisphere, random_screen)


def make(config):
    return InverseDistanceBound(config=config)


def patches(frustum, config, **size):
    """Patches around the origin of a frustum, and all that patch setup makes of them."""
    generator = np.random.default_rng(6)
    record = frustum(generator, config, **size)
    given = {**frustum_arrays(record), "vertices": scene_patches(generator, COUNT, record.origin, config.numbers),
             "surface": np.full(COUNT, SOURCE + 1)}
    return given | block("icu.patch_setup")[1].expect(given, config)


def vectors(given, config):
    threshold = settle_threshold(given["bound"], config)
    tables = table_writes(frustum_record(given, config), config)
    random.Random(1).shuffle(tables)
    return Vectors(
        ports={"frustum": frustum_of(given, config)}, tables=tables,
        items=[{**slot_of(k), "factor": factor_of(given, k), "window": window_of(given, k)} for k in range(COUNT)],
        expected={"o": [{**slot_of(k), "bound": int(given["bound"][k]), "threshold": int(threshold[k])}
                        for k in range(COUNT)]})


@pytest.mark.parametrize("frustum", FRUSTA)
def test_every_width_and_depth(frustum):
    check_block(make, lambda config: vectors(patches(frustum, config), config), interval=4)


@pytest.mark.parametrize("frustum", FRUSTA)
def test_the_largest_frustum(frustum):
    check_block(make, lambda config: vectors(patches(frustum, config, size=largest(config)), config), interval=4,
                variants=LIMITS)


@pytest.mark.parametrize("frustum", FRUSTA)
def test_the_vectors_hold_every_case(frustum):
    config = config_of({})
    given = patches(frustum, config)
    threshold, most = settle_threshold(given["bound"], config), config.icu.settle.high + 1
    assert_all_occur({
        "far": threshold == 1, "near": threshold == most, "between": (threshold > 1) & (threshold < most),
        "with rays": given["column_count"] > 0, "without rays": given["column_count"] == 0,
        "of one column": given["column_count"] == 1})


@pytest.mark.parametrize("simulator", SIMULATORS)
@pytest.mark.parametrize("frustum", FRUSTA)
def test_in_the_simulator(frustum, simulator):
    check_in_simulator(f"inverse_distance_bound-{frustum.__name__}", make,
                       lambda config: vectors(patches(frustum, config), config), simulator=simulator, interval=4)
