# amaranth: UnusedElaboratable=no

"""Pieces of rows: when they come, and what of them is kept. What they are is tested with the ray generator."""

from itertools import pairwise

from hw.ctu.row_pieces import RowPieces
from tb.ctu.window_stages import WindowStages
from tb.lib.configurations import config_of
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.timing import documented_latency

CONFIG = config_of({})
BENCH = ScheduleBench(RowPieces(config=CONFIG), ["i_table", "i"], ["o"], patience=60)
LOWEST, HIGHEST = -(1 << 27), (1 << 27) - 1


def test_pieces_of_whole_rows_and_of_a_window():
    stages = WindowStages("hemisphere", CONFIG, seed=3, last_shell=2)
    rays = stages.rays[2]
    # Half of a ring's columns, from the second half on.
    half, around = stages.record.columns << 7, stages.record.columns << 8
    whole = {"low": LOWEST, "end": HIGHEST, "wraps": 0}
    later = {"low": half, "end": HIGHEST, "wraps": 0}
    both = {"low": half + 512, "end": HIGHEST, "wraps": 1, "over": half - 512}
    stage = {"shell": 2, "row": 0, "row_number": 0, "rows": rays.rows, "columns": rays.columns}
    given = [{**stage, "window": whole}, {**stage, "window": later, "stage": 1},
             {**stage, "window": both, "stage": 2}, {"rows": 0, "final": 1}]
    came = BENCH.run(Schedule(
        items={"i_table": [(0, write) for write in stages.tables],
               "i": [(0 if number else len(stages.tables) + 2, one) for number, one in enumerate(given)]}, stalls={}),
        frustum=stages.ports["frustum"])["o"]
    position, columns = rays.column_position, rays.columns
    first, low, over = (int((position < bound).sum()) for bound in (half, half + 512, half - 512))
    assert position.max() < around
    pieces = [[(0, columns)], [(first, columns - first)], [(0, over), (low, columns - low)]]
    wanted = [{"stage": number, "row": row, "column": column, "ray": row * columns + column, "count": count}
              for number, parts in enumerate(pieces) for row in range(rays.rows) for column, count in parts]
    assert [{name: item[name] for name in wanted[0]} for item in came if not item["last"] | item["final"]] == wanted
    assert [item["last"] for item in came] == [
        mark for parts in pieces for mark in [0] * (len(parts) * rays.rows) + [1]] + [0]
    assert came[-1]["final"]
    cycles = BENCH.cycles["o"]
    assert cycles[0] - BENCH.cycles["i"][0] == documented_latency(RowPieces, CONFIG, columns=columns)
    assert {b - a for a, b in pairwise(cycles[:rays.rows])} == {5}, "a row of one piece takes five cycles"
