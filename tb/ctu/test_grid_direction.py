import numpy as np
import pytest

from golden.ctu.unit import global_directions
from golden.stimulus.ctu.grid_rays import draw_rays
from golden.stimulus.ctu.grids import shells
from golden.stimulus.frusta import random_hemisphere, random_screen
from hw.ctu.grid_direction import GridDirection
from tb.lib.block_bench import Vectors, check_block, check_in_simulator
from tb.lib.configurations import DEPTHS
from tb.lib.runner import SIMULATORS

RAYS = 200
VARIANTS = [{"icu.product_registers": depth} for depth in DEPTHS]


def make(config):
    return GridDirection(config=config, tag=9)


def vectors(config):
    return of_record(random_hemisphere, config)


def screen_vectors(config):
    return of_record(random_screen, config)


def of_record(frustum, config):
    random = np.random.default_rng(1)
    record = frustum(random, config)
    drawn, rays_of = draw_rays(random, record, RAYS), shells(record)
    items, directions = [], []
    for tag, (shell, row, column) in enumerate(zip(*(drawn[name].tolist() for name in ("shell", "row", "column")),
                                                   strict=True)):
        rays = rays_of(shell)
        # The second number of a screen's entries is 0.
        items.append({"tag": tag, "column": rays.column_table[column].tolist(), "row": rays.row_table[row].tolist()})
        directions.append(rays.direction[row, column])
    turned = global_directions(np.array(directions), record).tolist()
    return Vectors(ports={"is_screen": int(record.is_screen), "to_global": record.to_global.tolist()}, items=items,
                   expected={"o": [{"tag": tag, "direction": turned[tag]} for tag in range(RAYS)]})


@pytest.mark.parametrize("vectors", [vectors, screen_vectors])
def test_every_depth(vectors):
    check_block(make, vectors, variants=VARIANTS)


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    check_in_simulator("grid_direction", make, vectors, simulator=simulator)
