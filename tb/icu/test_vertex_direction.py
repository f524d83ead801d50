import pytest

from golden.stimulus import stimulus
from hw.icu.vertex_direction import VertexDirection
from tb.icu.vectors import rows, vertex_place
from tb.lib.block_bench import Vectors, check_block, check_in_simulator
from tb.lib.runner import SIMULATORS


def make(config):
    return VertexDirection(config=config)


def vectors(config):
    given = stimulus("icu.vertex_direction", count=400, seed=3, config=config).arrays
    vertices, directions = rows(given["vertex"]), rows(given["direction"])
    return Vectors(
        items=[{**vertex_place(k), "vertex": vertex} for k, vertex in enumerate(vertices)],
        expected={"o": [{**vertex_place(k), "vertex": vertex, "direction": directions[k],
                         "exponent": int(given["exponent"][k])} for k, vertex in enumerate(vertices)]})


def test_every_width_and_depth():
    check_block(make, vectors)


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    check_in_simulator("vertex_direction", make, vectors, simulator=simulator)
