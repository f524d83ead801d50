import random
from functools import partial

import numpy as np
import pytest

from golden.engine.icu.edge_planes import edge_planes
from golden.engine.icu.sbb import SphericalWindows
from golden.engine.icu.vertex_direction import vertex_direction
from golden.engine.stimulus.frusta import frustum_arrays, frustum_record, random_hemisphere
from golden.engine.stimulus.icu.edge_planes import plane_arrays, planes_of
from golden.engine.stimulus.patches import r_patches
from hw.icu.sbb import Sbb
from radiosity.flow.package.example.frustum_load import table_writes
from tb.icu.vectors import (
    LIMITS,
    assert_all_occur,
    frustum_of,
    largest,
    rows,
    seen_through,
    slot_of,
    winding_of,
    window_of,
)
from tb.lib.bench import Bench, Case, Vectors
from tb.lib.configurations import CONFIGURATIONS, config_of
from tb.lib.runner import SLOW_IN_ICARUS

COUNT = 200


def small_frustum(config):
    return seen_through(random_hemisphere(np.random.default_rng(3), config), "icu.sbb", count=COUNT, seed=3,
                        config=config)


def largest_frustum(config):
    record = random_hemisphere(np.random.default_rng(4), config, largest(config))
    return seen_through(record, "icu.sbb", count=COUNT, seed=4, config=config)


def around_the_axis(config):
    """Patches with a vertex on the axis, or with an edge or a diagonal that passes it."""
    patches, number = r_patches(np.random.default_rng(5), COUNT, config.numbers), np.arange(COUNT)
    on, across = np.split(number, 2)
    patches[on, on % 4, :2] = 0
    patches[across, across % 4] = patches[across, (across % 4 + 1 + across // 4 % 3) % 4] * [-1, -1, 1]
    direction, _ = vertex_direction(patches, config.numbers)
    record = random_hemisphere(np.random.default_rng(5), config)
    return frustum_arrays(record) | {"direction": direction} | plane_arrays(edge_planes(direction, config.numbers))


class Moved(SphericalWindows):
    """The windows of patches all of whose angles are larger by (azimuth, polar), each P x 1 or a number."""

    def __init__(self, given, config, by):
        super().__init__(frustum_record(given, config), config)
        self.by, self.turn = by, 1 << config.icu.angle_bits

    def angles(self, directions):
        azimuth, polar = super().angles(directions)
        return (azimuth + self.by[0]) % self.turn, polar + self.by[1]


def to_the_borders(given, config):
    """How far angles may be moved until a border of their windows moves; that far, and a unit farther."""
    def ends(by):
        window = Moved(given, config, by).windows(given["direction"], planes_of(given))
        return (window.column_first, window.column_first + window.column_count,
                window.row_first, window.row_first + window.row_count)

    moves, icu = [], config.icu
    before = ends((0, 0))
    for border in range(4):
        bits = icu.angle_bits - given["frustum_column_bits"] if border < 2 else \
            icu.angle_bits - 2 - given["frustum_row_bits"]
        near, far = (np.full((COUNT, 1), value) for value in (0, 1 << bits))

        def along(by, axis=border // 2):
            return (by, 0) if axis == 0 else (0, by)

        for _ in range(bits):
            middle = near + far >> 1
            moved = (ends(along(middle))[border] != before[border])[:, None]
            near, far = np.where(moved, near, middle), np.where(moved, middle, far)
        moves += [along(near), along(far)]
    return moves


def vectors(draw, config, moves_of=lambda given, config: [(0, 0)]):
    given = draw(config)
    tables = table_writes(frustum_record(given, config), config)
    random.Random(1).shuffle(tables)
    direction, planes = given["direction"], planes_of(given)
    signs = rows(np.sign(planes.planes[:, :5]))
    front = ((direction[..., 2] > 0) << np.arange(4)).sum(axis=1)
    items, expected = [], []
    for number, by in enumerate(moves_of(given, config)):
        windows = Moved(given, config, by)
        first, second = windows.angles(direction)
        window = vars(windows.windows(direction, planes))
        slots = [slot_of(number * COUNT + k) for k in range(COUNT)]
        items += [{**slots[k], "first": rows(first[k]), "second": rows(second[k]), "front": int(front[k]),
                   "winding": winding_of(given, k), "signs": signs[k]} for k in range(COUNT)]
        expected += [{**slots[k], "window": window_of(window, k)} for k in range(COUNT)]
    return Vectors(ports={"frustum": frustum_of(given, config)}, first={"i_table": tables}, inputs={"i": items},
                   expected={"o": expected})


class TestSbb(Bench):
    component, interval, simulators = Sbb, 4, SLOW_IN_ICARUS
    cases = {"small frustum": Case(partial(vectors, small_frustum), [*CONFIGURATIONS.values(), {"icu.side_bits": 16}]),
             # Only coarse angles often lie at the very border of a window.
             "largest frustum": Case(partial(vectors, largest_frustum), [*LIMITS, {"icu.angle_bits": 18}],
                                     simulated=False),
             "axis": Case(partial(vectors, around_the_axis), []),
             "borders": Case(partial(vectors, largest_frustum, moves_of=to_the_borders), [])}


@pytest.mark.parametrize("given", [small_frustum, largest_frustum])
def test_the_vectors_hold_every_case(given):
    given = given(config_of({}))
    first, count, columns = given["column_first"], given["column_count"], given["frustum_columns"]
    assert_all_occur({
        "a part of the ring": (count > 0) & (count < columns), "the whole ring": count == columns,
        "over azimuth 0": first + count > columns, "around the pole": (count == columns) & (given["row_first"] == 0),
        "without rays": count == 0, "split": given["split"], "edge-on": ~given["orientation"].any(axis=1),
        "down to the horizon": given["row_first"] + given["row_count"] == given["frustum_rows"]})
