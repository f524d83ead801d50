import pytest

from hw.icu.vertex_gather import VertexGather
from tb.icu.vectors import slot_of, vertex_place
from tb.lib.block_bench import Vectors, check_block, check_in_simulator
from tb.lib.runner import SIMULATORS


def make(config):
    return VertexGather(config=config, shape=8)


def vectors(config):
    values = [(7 * k + k // 3) % 256 for k in range(200)]
    return Vectors(
        items=[{**vertex_place(k), "item": value} for k, value in enumerate(values)],
        expected={"o": [{**slot_of(k), "items": values[4 * k:4 * k + 4]} for k in range(50)]})


def test_every_width_and_depth():
    check_block(make, vectors, items_per_result=4, variants=[{}])


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    check_in_simulator("vertex_gather", make, vectors, simulator=simulator)
