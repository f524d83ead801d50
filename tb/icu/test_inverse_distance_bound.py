import random
from functools import partial

import numpy as np
import pytest

from golden.engine.icu.settle_code import settle_threshold
from golden.engine.stimulus import block
from golden.engine.stimulus.frusta import (
    SOURCE,
    frustum_arrays,
    frustum_record,
    random_hemisphere,
    random_screen,
)
from golden.engine.stimulus.patches import scene_patches
from hw.icu.inverse_distance_bound import InverseDistanceBound
from radiosity.flow.package.example.frustum_load import table_writes
from tb.icu.shadow_frustum import random_shadow
from tb.icu.vectors import LIMITS, SHADOWS, assert_all_occur, factor_of, frustum_of, largest, slot_of, window_of
from tb.lib.bench import Bench, Case, Vectors
from tb.lib.configurations import config_of

COUNT = 160
FRUSTA = (random_hemisphere, random_screen)


def patches(frustum, config, **size):
    """Patches around the origin of a frustum, and all that patch setup makes of them."""
    generator = np.random.default_rng(6)
    record = frustum(generator, config, **size)
    given = {**frustum_arrays(record), "vertices": scene_patches(generator, COUNT, record.origin, config.numbers),
             "surface": np.full(COUNT, SOURCE + 1)}
    return given | block("icu.patch_setup")[1].expect(given, config)


def vectors(frustum, config, **size):
    given = patches(frustum, config, **size)
    threshold = settle_threshold(given["bound"], config)
    tables = table_writes(frustum_record(given, config), config)
    random.Random(1).shuffle(tables)
    return Vectors(
        ports={"frustum": frustum_of(given, config)}, first={"i_table": tables},
        inputs={"i": [{**slot_of(k), "factor": factor_of(given, k), "window": window_of(given, k)}
                      for k in range(COUNT)]},
        expected={"o": [{**slot_of(k), "bound": int(given["bound"][k]), "threshold": int(threshold[k])}
                        for k in range(COUNT)]})


class TestInverseDistanceBound(Bench):
    component, interval = InverseDistanceBound, 4
    cases = {frustum.__name__: partial(vectors, frustum) for frustum in FRUSTA} | {
        f"largest {frustum.__name__}": Case(
            lambda config, frustum=frustum: vectors(frustum, config, size=largest(config)), LIMITS, simulated=False)
        for frustum in FRUSTA} | {
        f"{frustum.__name__} beside shadows": Case(partial(vectors, frustum), SHADOWS, simulated=False)
        for frustum in (*FRUSTA, random_shadow)}


@pytest.mark.parametrize("frustum", FRUSTA)
def test_the_vectors_hold_every_case(frustum):
    config = config_of({})
    given = patches(frustum, config)
    threshold, most = settle_threshold(given["bound"], config), config.icu.settle.high + 1
    assert_all_occur({
        "far": threshold == 1, "near": threshold == most, "between": (threshold > 1) & (threshold < most),
        "with rays": given["column_count"] > 0, "without rays": given["column_count"] == 0,
        "of one column": given["column_count"] == 1})
