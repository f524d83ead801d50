import numpy as np
import pytest

from golden.stimulus import stimulus
from hw.icu.edge_planes import EdgePlanes
from tb.icu.vectors import rows, slot_of, winding_of
from tb.lib.block_bench import Vectors, check_block, check_in_simulator
from tb.lib.runner import SIMULATORS


def make(config):
    return EdgePlanes(config=config)


def vectors(config):
    given = stimulus("icu.edge_planes", count=200, seed=3, config=config).arrays
    signs = rows(np.sign(given["planes"][:, :5]))
    return Vectors(
        items=[{**slot_of(k), "directions": vertices} for k, vertices in enumerate(rows(given["direction"]))],
        expected={"o_planes": [{**slot_of(k), "part": planes} for k, planes in enumerate(rows(given["planes"]))],
                  "o": [{**slot_of(k), "winding": winding_of(given, k), "signs": signs[k]} for k in range(200)]})


def test_every_width_and_depth():
    check_block(make, vectors, interval=4)


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    check_in_simulator("edge_planes", make, vectors, simulator=simulator, interval=4)
