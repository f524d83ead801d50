from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from golden.icu.section_clip import SectionWindow
from golden.icu.window_walk import ray_address, window_rays, window_tiles
from hw.icu.window_walk import WindowWalk
from tb.lib.configurations import config_of
from tb.lib.coverage import Coverage
from tb.lib.schedules import SETTINGS, Schedule, ScheduleBench, payloads, schedules
from tb.lib.timing import documented_latency

# Of the section.
COLUMNS, ROWS = 27, 14
PARTS = ("column_first", "column_count", "wrapped_count", "row_first", "row_count")


@st.composite
def windows(draw):
    """A window of the section: without rays, of one ray, in one piece, in two, or all around."""
    kind = draw(st.sampled_from(("none", "one ray", "one piece", "two pieces", "ring")))
    if kind == "none":
        return dict.fromkeys(PARTS, 0)
    first, row = draw(st.integers(0, COLUMNS - 1)), draw(st.integers(0, ROWS - 1))
    if kind == "one ray":
        return {"column_first": first, "column_count": 1, "wrapped_count": 0, "row_first": row, "row_count": 1}
    rows = draw(st.integers(1, ROWS - row))
    if kind == "one piece":
        count, wrapped = draw(st.integers(1, COLUMNS - first)), 0
    else:
        count, wrapped = COLUMNS - first, first if kind == "ring" else draw(st.integers(0, first))
    return {"column_first": first, "column_count": count, "wrapped_count": wrapped, "row_first": row, "row_count": rows}


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


@pytest.mark.parametrize("tile_bits", [1, 2, 3])
def test_every_window_tile_by_tile(tile_bits):
    config = config_of({"icu.tile_bits": tile_bits, "icu.side_bits": 6})
    walk = WindowWalk(config=config)
    assert walk.latency == documented_latency(WindowWalk, config)
    across = -(-COLUMNS >> tile_bits)
    bench = ScheduleBench(walk, ["i"], ["o"], idle_limit=walk.latency + 4)
    coverage = Coverage(["no rays", "one ray", "one piece", "two pieces", "whole ring", "a tile of both pieces",
                         "one tile", "several rows of tiles", "a step waits", "a window waits",
                         "windows without a gap"])
    items = st.builds(lambda slot, threshold, window: {"slot": slot, "threshold": threshold, "window": window},
                      payloads(walk.i.payload.slot.shape()), payloads(walk.i.payload.threshold.shape()), windows())

    @SETTINGS
    @given(schedules({"i": items}, ["o"], most=12))
    def run(schedule):
        came, given = bench.run(schedule, tiles_across=across)["o"], schedule.values("i")
        window = golden_window([item["window"] for item in given])
        tiles = window_tiles(window, config.icu).tolist()
        assert len(came) == sum(tiles), "steps must be as many as tiles"
        steps, ends = iter(came), np.cumsum(tiles).tolist()
        for k, item in enumerate(given):
            mine = [next(steps) for _ in range(tiles[k])]
            assert all((step["slot"], step["threshold"]) == (item["slot"], item["threshold"]) for step in mine)
            assert [step["last"] for step in mine] == [0] * (tiles[k] - 1) + [1]
            columns, rows = window_rays(window, k, config.icu)
            assert [ray for step in mine for ray in rays_of(step, config)] == list(zip(
                ray_address(columns, rows, across, config.icu).tolist(), columns.tolist(), rows.tolist(), strict=True))
        cycles = bench.cycles["o"]
        if cycles and not any(schedule.stalls["o"]):
            assert cycles[0] - bench.cycles["i"][0] == walk.latency
            for first, last in zip([0, *ends], ends, strict=False):
                assert cycles[last - 1] - cycles[first] == last - 1 - first, "a window takes a cycle per tile"
        both = window.column_count + window.wrapped_count
        follows = [b - a for k, (a, b) in enumerate(pairwise(cycles)) if k + 1 in ends]
        coverage.hit_all({
            "no rays": window.rays == 0, "one ray": window.rays == 1,
            "one piece": (window.rays > 0) & (window.wrapped_count == 0), "two pieces": window.wrapped_count > 0,
            "whole ring": both == COLUMNS,
            "a tile of both pieces": (window.wrapped_count > 0) & (
                window.wrapped_count - 1 >> tile_bits == window.column_first >> tile_bits),
            "one tile": np.array(tiles) == 1,
            "several rows of tiles": window.row_first + np.maximum(window.row_count, 1) - 1 >> tile_bits
            > window.row_first >> tile_bits,
            "a step waits": [b - a > 1 for k, (a, b) in enumerate(pairwise(cycles)) if k + 1 not in ends],
            "a window waits": [b - a > 1 for (idle, _), (a, b) in zip(
                schedule.items["i"][1:], pairwise(bench.cycles["i"]), strict=True) if not idle],
            "windows without a gap": [gap == 1 for gap in follows]})

    run()
    coverage.check()


def test_a_window_that_comes_during_a_stall_costs_no_cycle():
    """It is loaded while the step before it waits."""
    config = config_of({"icu.side_bits": 6})
    walk = WindowWalk(config=config)
    bench = ScheduleBench(walk, ["i"], ["o"], idle_limit=2 * walk.latency)
    window = {"column_first": 0, "column_count": 1, "wrapped_count": 0, "row_first": 0, "row_count": 1}
    items = [(idle, {"slot": 0, "threshold": 0, "window": window}) for idle in (0, 2 * walk.latency)]
    bench.run(Schedule(items={"i": items}, stalls={"o": [6 * walk.latency]}),
              tiles_across=-(-COLUMNS >> config.icu.tile_bits))
    first, second = bench.cycles["o"]
    assert first > bench.cycles["i"][1] + walk.latency, "the stall must outlast the second window's latency"
    assert second == first + 1
