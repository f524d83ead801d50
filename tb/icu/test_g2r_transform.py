from functools import partial

import numpy as np
import pytest

from golden.engine.icu.g2r_transform import g2r_transform
from golden.engine.stimulus import stimulus
from golden.engine.stimulus.frusta import frustum_record
from hw.icu.g2r_transform import G2rTransform
from tb.icu.vectors import assert_all_occur, frustum_of, rows, vertex_key
from tb.lib.bench import Bench, Vectors
from tb.lib.configurations import CONFIGURATIONS, config_of


def drawn(config):
    return stimulus("icu.g2r_transform", count=200, seed=3, config=config).arrays


def along_the_axes(config):
    """As drawn, but the frustum is not turned: every fourth offset of a coordinate ends in just a half."""
    given = drawn(config)
    given |= {"frustum_matrix": np.array([[0, 1, 0], [-1, 0, 0], [0, 0, 1]]) << config.numbers.direction_fraction}
    return given | {"transformed": g2r_transform(frustum_record(given, config), given["vertex"])}


def of(draw, config):
    given = draw(config)
    return Vectors(ports={"frustum": frustum_of(given, config)},
                   inputs={"i": [{**vertex_key(k), "vertex": vertex}
                                 for k, vertex in enumerate(rows(given["vertex"]))]},
                   expected={"o": [{**vertex_key(k), "vertex": vertex}
                                   for k, vertex in enumerate(rows(given["transformed"]))]})


class TestG2rTransform(Bench):
    component = G2rTransform
    cases = {given.__name__: partial(of, given) for given in (drawn, along_the_axes)}


@pytest.mark.parametrize("changes", CONFIGURATIONS.values(), ids=CONFIGURATIONS)
def test_halves_of_both_signs_occur(changes):
    numbers, given = config_of(changes).numbers, along_the_axes(config_of(changes))
    exact = (given["vertex"] - given["frustum_origin"]) @ given["frustum_matrix"].T
    one = 1 << numbers.scene_bits + numbers.direction_fraction - numbers.vector_fraction
    assert_all_occur({f"row {row}, sign {sign}": (exact % one == one >> 1)[:, row] & (np.sign(exact)[:, row] == sign)
                      for row in range(3) for sign in (-1, 1)})
