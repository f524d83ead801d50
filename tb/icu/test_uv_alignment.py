import pytest

from golden.stimulus import stimulus
from hw.icu.uv_alignment import UvAlignment
from tb.icu.vectors import rows
from tb.lib.block_bench import Vectors, check_block, check_in_simulator
from tb.lib.runner import SIMULATORS


def make(config):
    return UvAlignment(config=config, tag=9)


def vectors(config):
    given = stimulus("icu.uv_subdivision", count=400, seed=3, config=config).arrays
    aligned = rows(given["aligned"] * given["held"][:, None])
    return Vectors(
        items=[{"tag": k, "distances": rows(given["distances"][k]), "orientation": int(given["held"][k]),
                "exponents": rows(given["exponents"][k])} for k in range(400)],
        expected={"o": [{"tag": k, "distances": aligned[k]} for k in range(400)]})


def test_every_width_and_depth():
    check_block(make, vectors)


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    check_in_simulator("uv_alignment", make, vectors, simulator=simulator)
