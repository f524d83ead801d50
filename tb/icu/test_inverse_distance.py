from functools import partial

import numpy as np
import pytest

from golden.engine.icu.inverse_distance import SMALLEST, inverse_distance
from golden.engine.stimulus import stimulus
from golden.engine.stimulus.icu.plane_factor import factor_of
from hw.icu.inverse_distance import InverseDistance
from tb.icu.vectors import assert_all_occur, rows
from tb.lib.bench import Bench, Vectors
from tb.lib.configurations import CONFIGURATIONS, config_of

COUNT = 400


def drawn(config):
    return stimulus("icu.inverse_distance", count=COUNT, seed=3, config=config).arrays


def along_the_planes(config):
    """Planes across an axis, and rays that lie in them or all but do."""
    given, number = drawn(config), np.arange(COUNT)
    across = number % 3
    given["mantissa"] *= np.arange(3) == across[:, None]
    given["ray"][number, across] = number // 3 % 3 - 1
    return given | {"inverse": inverse_distance(factor_of(given), given["ray"], config.numbers)}


def of(draw, config):
    given = draw(config)
    return Vectors(
        inputs={"i": [{"tag": k, "direction": rows(given["ray"][k]), "mantissa": rows(given["mantissa"][k]),
                       "exponent": int(given["factor_exponent"][k])} for k in range(COUNT)]},
        expected={"o": [{"tag": k, "inverse": int(given["inverse"][k])} for k in range(COUNT)]})


class TestInverseDistance(Bench):
    component, arguments = InverseDistance, {"tag": 9}
    cases = {given.__name__: partial(of, given) for given in (drawn, along_the_planes)}


@pytest.mark.parametrize("changes", CONFIGURATIONS.values(), ids=CONFIGURATIONS)
def test_the_vectors_hold_every_case(changes):
    config = config_of(changes)
    inverse, high = drawn(config)["inverse"], config.numbers.inverse.high
    beside = along_the_planes(config)
    side = np.sign(np.einsum("ki,ki->k", beside["mantissa"], beside["ray"]))
    assert_all_occur({"farthest": inverse == SMALLEST, "nearest": inverse == high,
                      "between": (inverse > SMALLEST) & (inverse < high),
                      **{f"in a plane or beside it, {sign}": side == sign for sign in (-1, 0, 1)}})
