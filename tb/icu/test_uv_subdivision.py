from functools import partial

import pytest

from golden.engine.stimulus import stimulus
from hw.icu.uv_subdivision import UvSubdivision
from tb.icu.vectors import assert_all_occur, rows
from tb.lib.bench import Bench, Case, Vectors
from tb.lib.configurations import CONFIGURATIONS, config_of

# The low bits of distances seldom decide.
FEW, MANY = 400, 4000
TAG = 9


def drawn(config, count=FEW):
    return stimulus("icu.uv_subdivision", count=count, seed=3, config=config).arrays


def vectors(config, count=FEW):
    given = drawn(config, count)
    aligned, tags = rows(given["aligned"] * given["held"][:, None]), [k % (1 << TAG) for k in range(count)]
    return Vectors(
        inputs={"i": [{"tag": tags[k], "distances": aligned[k]} for k in range(count)]},
        expected={"o": [{"tag": tags[k], "u": int(given["u"][k]), "v": int(given["v"][k])} for k in range(count)]})


class TestUvSubdivision(Bench):
    component, arguments = UvSubdivision, {"tag": TAG}
    cases = {"few": Case(vectors, simulated=False), "many": Case(partial(vectors, count=MANY), [])}


@pytest.mark.parametrize("changes", CONFIGURATIONS.values(), ids=CONFIGURATIONS)
def test_the_vectors_hold_every_case(changes):
    config = config_of(changes)
    given = drawn(config)
    u, v, most = given["u"], given["v"], config.icu.uv.high
    assert_all_occur({
        **{f"in corner {a, b}": (u == a) & (v == b) for a in (0, most) for b in (0, most)},
        "on an edge": ((u == 0) | (u == most)) != ((v == 0) | (v == most)),
        "inside": (u > 0) & (u < most) & (v > 0) & (v < most),
        **{f"held by orientation {turn}": given["held"] == turn for turn in (-1, 1)},
        "with a distance of 0": (given["distances"] == 0).any(axis=1)})
