from functools import partial

import numpy as np

from golden.engine.ctu.grid_rays import FRACTION
from golden.engine.ctu.unit import global_directions
from golden.engine.lib.fixed import round_shift
from golden.engine.stimulus.ctu.grid_rays import draw_rays
from golden.engine.stimulus.ctu.grids import shells
from golden.engine.stimulus.frusta import random_hemisphere, random_screen
from hw.ctu.grid_direction import GridDirection
from tb.lib.bench import Bench, Case, Vectors
from tb.lib.configurations import CONFIGURATIONS, DEPTHS
from tb.lib.runner import SLOW_IN_ICARUS

RAYS = 200
# Entries that are drawn to find such as are at halves.
MANY = 200_000
FRUSTA = (random_hemisphere, random_screen)


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
    return Vectors(ports={"is_screen": int(record.is_screen), "to_global": record.to_global.tolist()},
                   inputs={"i": items},
                   expected={"o": [{"tag": tag, "direction": turned[tag]} for tag in range(RAYS)]})


def vectors_at_halves(frustum, seed, config):
    """Entries for which a number before it is rounded is as near to a half as it gets: there all its bits matter."""
    random, one = np.random.default_rng(seed), 1 << FRACTION
    record = frustum(random, config)
    row, column = (random.integers(-one, one, (MANY, 2), endpoint=True) for _ in range(2))
    # A column's numbers are a cosine and a sine: not both are near to 1.
    column = np.rint(column / np.maximum(1, np.hypot(*column.T) / one)[:, None]).astype(np.int64)
    products = row[:, :1] * column
    if record.is_screen:
        column[:, 1] = row[:, 1] = 0
        local = np.stack([column[:, 0], row[:, 0], np.full(MANY, one)], axis=1)
    else:
        local = np.concatenate([round_shift(products, FRACTION), row[:, 1:]], axis=1)
    sums = local @ record.to_global.T
    rounded = sums if record.is_screen else np.concatenate([products, sums], axis=1)
    nearest = np.unique(np.argsort(np.abs(rounded % one - one // 2), axis=0)[:RAYS // 4])
    # Of both signs and of all numbers by turns; as many as the part under stalls takes.
    nearest = random.permutation(nearest)[:len(nearest) & ~3]
    directions = global_directions(local[nearest], record).tolist()
    return Vectors(ports={"is_screen": int(record.is_screen), "to_global": record.to_global.tolist()},
                   inputs={"i": [{"tag": tag, "column": column[index].tolist(), "row": row[index].tolist()}
                                 for tag, index in enumerate(nearest)]},
                   expected={"o": [{"tag": tag, "direction": direction} for tag, direction in enumerate(directions)]})


class TestGridDirection(Bench):
    component, arguments, simulators = GridDirection, {"tag": 9}, SLOW_IN_ICARUS
    # Numbers of grid rays have the same width in all configurations.
    variants = [*({"icu.product_registers": depth} for depth in DEPTHS), CONFIGURATIONS["narrow"]]
    cases = {frustum.__name__: partial(of_record, frustum) for frustum in FRUSTA} | {
        f"{frustum.__name__} at halves, {seed}": Case(
            partial(vectors_at_halves, frustum, seed), None if seed == 0 else [])
        for seed in range(3) for frustum in FRUSTA}
