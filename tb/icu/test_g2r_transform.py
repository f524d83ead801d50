import pytest

from golden.stimulus import stimulus
from hw.icu.g2r_transform import G2rTransform
from tb.icu.vectors import frustum_of, vertex_place
from tb.lib.block_bench import Vectors, check_block, check_in_simulator
from tb.lib.runner import SIMULATORS


def make(config):
    return G2rTransform(config=config)


def vectors(config):
    given = stimulus("icu.g2r_transform", count=200, seed=3, config=config).arrays
    return Vectors(ports={"frustum": frustum_of(given, config)},
                   items=[{**vertex_place(k), "vertex": vertex} for k, vertex in enumerate(given["vertex"].tolist())],
                   expected={"o": [{**vertex_place(k), "vertex": vertex}
                                   for k, vertex in enumerate(given["transformed"].tolist())]})


def test_every_width_and_depth():
    check_block(make, vectors)


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    check_in_simulator("g2r_transform", make, vectors, simulator=simulator)
