from itertools import islice

import numpy as np

from golden.engine.icu.section_clip import SectionWindow
from golden.engine.icu.window_walk import ray_address, window_rays, window_tiles
from hw.icu.window_walk import WindowWalk
from tb.icu.vectors import assert_all_occur
from tb.lib.bench import Bench, Vectors
from tb.lib.stages import Elastic, Expand, Rigid

COUNT = 60
# Of the section.
COLUMNS, ROWS = 27, 14
TILE = ("tile", "tile_row", "tile_column", "columns", "rows")
PARTS = ("column_first", "column_count", "wrapped_count", "row_first", "row_count")


def windows():
    """Windows of the section: of no ray, of one, in one piece, in two, all around, or from the last column on."""
    draw = np.random.default_rng(3)
    for number in range(COUNT):
        kind = ("none", "one ray", "one piece", "two pieces", "ring", "last column")[number % 6]
        first, row = (int(draw.integers(count)) for count in (COLUMNS, ROWS))
        first = COLUMNS - 1 if kind == "last column" else first
        rows, count, wrapped = int(draw.integers(1, ROWS - row, endpoint=True)), COLUMNS - first, 0
        if kind == "none":
            first = row = rows = count = 0
        elif kind == "one ray":
            rows = count = 1
        elif kind == "one piece":
            count = int(draw.integers(1, COLUMNS - first, endpoint=True))
        else:
            wrapped = first if kind == "ring" else int(draw.integers(first, endpoint=True))
        yield dict(zip(PARTS, (first, count, wrapped, row, rows), strict=True))


def golden_window(given):
    return SectionWindow(**{name: np.array([window[name] for window in given], dtype=np.int64)
                            for name in PARTS})


def rays_of(step, config):
    """The rays of a step: address in the ray memory, and column and row of the section."""
    side = config.icu.tile_bits
    lanes = range(1 << side)
    return [(step["tile"] << 2 * side | row << side | column, (step["tile_column"] << side) + column,
             (step["tile_row"] << side) + row)
            for row in lanes for column in lanes if step["columns"] >> column & 1 and step["rows"] >> row & 1]


class TestWindowWalk(Bench):
    """Every window tile by tile."""

    component, changes, splits = WindowWalk, {"icu.side_bits": 6}, False
    variants = [{"icu.tile_bits": bits} for bits in (1, 2, 3)]

    def vectors(self, config):
        given = list(windows())
        window = golden_window(given)
        tiles = window_tiles(window, config.icu).tolist()
        return Vectors(
            ports={"tiles_across": -(-COLUMNS >> config.icu.tile_bits)}, about=(config, window, tiles),
            inputs={"i": [{"slot": number % config.icu.slots, "threshold": number, "window": one}
                          for number, one in enumerate(given)]},
            expected={"o": [{"slot": number % config.icu.slots, "threshold": number, "last": int(k + 1 == count),
                             **dict.fromkeys(TILE)} for number, count in enumerate(tiles) for k in range(count)]})

    def check(self, given, came):
        super().check(given, came)
        (config, window, tiles), steps = given.about, iter(self.values("o", came))
        for number, count in enumerate(tiles):
            columns, rows = window_rays(window, number, config.icu)
            address = ray_address(columns, rows, given.ports["tiles_across"], config.icu)
            assert [ray for step in islice(steps, count) for ray in rays_of(step, config)] == list(zip(
                address.tolist(), columns.tolist(), rows.tolist(), strict=True)), f"window {number}"

    def stages(self, component, config):
        """Registers in front of a skid buffer, the window that is walked, and the step that is offered."""
        return [Rigid(component.latency - 3), Elastic(1, 2), Rigid(1), Expand(self.now.about[2], holds=True), Rigid(1)]


def test_the_windows_hold_every_case():
    given, bits = TestWindowWalk().vectors(TestWindowWalk().config()), TestWindowWalk().config().icu.tile_bits
    _, window, tiles = given.about
    tile = [window.column_first >> bits, window.wrapped_count - 1 >> bits]
    assert_all_occur({
        "no rays": window.rays == 0, "one ray": window.rays == 1,
        "one piece": (window.rays > 0) & (window.wrapped_count == 0), "two pieces": window.wrapped_count > 0,
        "one column of tiles, and the other piece, in several rows of tiles":
            (window.column_first == COLUMNS - 1) & (window.wrapped_count > 0)
            & (window.row_first + window.row_count - 1 >> bits > window.row_first >> bits),
        "whole ring": window.column_count + window.wrapped_count == COLUMNS,
        "a tile of both pieces": (window.wrapped_count > 0) & (tile[0] == tile[1]), "one tile": np.array(tiles) == 1,
        "several rows of tiles": window.row_first + np.maximum(window.row_count, 1) - 1 >> bits
        > window.row_first >> bits})
