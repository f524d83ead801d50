import pytest

from golden.icu.screening import edge_distances, inside
from golden.stimulus import stimulus
from golden.stimulus.icu.edge_planes import planes_of
from hw.icu.screening import Screening
from tb.icu.vectors import rows, turns_of
from tb.lib.block_bench import Vectors, check_block, check_in_simulator
from tb.lib.runner import SIMULATORS


def make(config):
    return Screening(config=config, tag=9)


def vectors(config):
    given = stimulus("icu.intersection", count=400, seed=3, config=config).arrays
    planes = planes_of(given)
    distances = edge_distances(planes, given["ray"], config.numbers)
    held, orientation = inside(distances, planes)
    return Vectors(
        items=[{"tag": k, "direction": rows(given["ray"][k]), "planes": rows(given["planes"][k]),
                "turns": turns_of(given, k)} for k in range(400)],
        expected={"o": [{"tag": k, "distances": rows(distances[k]), "inside": int(held[k]),
                         "orientation": int(orientation[k])} for k in range(400)]})


def test_every_width_and_depth():
    check_block(make, vectors)


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    check_in_simulator("screening", make, vectors, simulator=simulator)
