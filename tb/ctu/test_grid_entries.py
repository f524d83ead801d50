import numpy as np
import pytest

from golden.stimulus.ctu.grids import shells
from golden.stimulus.frusta import random_hemisphere
from hw.ctu.grid_entries import GridEntries
from tb.ctu.grid_load import GridPlaces, grid_writes
from tb.lib.block_bench import Vectors, check_block, check_in_simulator
from tb.lib.runner import SIMULATORS

RAYS = 160


def make(config):
    return GridEntries(config=config, tag=9)


def vectors(config):
    random = np.random.default_rng(2)
    record = random_hemisphere(random, config)
    rays = [shells(record)(shell) for shell in range(2, 6)]
    ways = {one.shell: ((one.shell - 1 << 16) + 5, one.shell << 16) for one in rays}
    places, items, expected = GridPlaces(rays), [], []
    for tag in range(RAYS):
        one = rays[random.integers(len(rays))]
        number = int(random.integers(one.rows * one.columns))
        request, (row, column) = places.request(one, number), divmod(number, one.columns)
        begin, end = ways[one.shell]
        items.append({"tag": tag, **{name: request[name] for name in ("shell", "row", "column")}})
        expected.append({"tag": tag, "begin": begin, "length": end - begin, "row": one.row_table[row].tolist(),
                         "column": one.column_table[column].tolist()})
    return Vectors(items=items, expected={"o": expected}, tables=grid_writes(rays, config, ways=ways))


def test_entries_of_the_tables():
    check_block(make, vectors, variants=[{}])


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    check_in_simulator("grid_entries", make, vectors, simulator=simulator)
