"""Pieces of rows: when they come, and what of them is kept. What they are is tested with the ray generator."""

from dataclasses import replace
from itertools import pairwise

import numpy as np

from golden.engine.ctu.sector import Sector, sector_rays
from golden.engine.stimulus.ctu.grids import shells
from golden.engine.stimulus.frusta import random_hemisphere
from hw.ctu.position_search import PositionSearch
from hw.ctu.row_pieces import RowPieces
from tb.ctu.window_stages import WindowStages
from tb.lib.configurations import config_of
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.timing import documented_latency

CONFIG = config_of({})
BENCH = ScheduleBench(RowPieces(config=CONFIG), idle_limit=60)
LOWEST, HIGHEST = -(1 << 27), (1 << 27) - 1
# Of a quarter of a hemisphere.
SHELL = 8


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
        first={"i_table": stages.tables}, items={"i": [(2 * (not k), one) for k, one in enumerate(given)]}),
        frustum=stages.ports["frustum"])["o"]
    position, columns = rays.column_position, rays.columns
    first, low, over = (int((position < bound).sum()) for bound in (half, half + 512, half - 512))
    assert position.max() < around
    pieces = [[(0, columns)], [(first, columns - first)], [(0, over), (low, columns - low)]]
    expected = [{"stage": number, "row": row, "column": column, "ray": row * columns + column, "count": count}
              for number, parts in enumerate(pieces) for row in range(rays.rows) for column, count in parts]
    assert [{name: item[name] for name in expected[0]} for item in came if not item["last"] | item["final"]] == expected
    assert [item["last"] for item in came] == [
        mark for parts in pieces for mark in [0] * (len(parts) * rays.rows) + [1]] + [0]
    assert came[-1]["final"]
    cycles = BENCH.cycles["o"]
    assert cycles[0] - BENCH.cycles["i"][0] == documented_latency(RowPieces, CONFIG, columns=columns)
    assert {b - a for a, b in pairwise(cycles[:rays.rows])} == {5}, "a row of one piece takes five cycles"


class Quarter(WindowStages):
    """A quarter of a hemisphere."""

    def __init__(self, change=lambda rays: rays):
        record = random_hemisphere(np.random.default_rng(1), CONFIG, size=(256, 64))
        of = shells(record)
        self._prepare(record, Sector(64, 128, 0, 64), lambda shell: change(of(shell)), SHELL, CONFIG)

    @property
    def mask(self):
        """The grid rays of the last shell in the sector, whose arcs are others in each row."""
        rays = self.rays[SHELL]
        assert len(np.unique(rays.column_border)) > rays.rows // 4
        return sector_rays(rays, self.sector, self.record)

    @property
    def rows(self):
        """Rows of one piece; near the pole there are two, or all columns."""
        mask = self.mask
        pieces = (np.diff(np.pad(mask, ((0, 0), (1, 0))).astype(int), axis=1) == 1).sum(axis=1)
        rows = np.flatnonzero((pieces == 1) & ~mask.all(axis=1))
        rows = max(np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1), key=len)
        assert len(rows) > 12
        return rows


def check_pieces(stages, rows):
    """Those that come are golden's, which are returned."""
    rays, mask, shell = stages.rays[SHELL], stages.mask, SHELL
    whole = {"low": LOWEST, "end": HIGHEST, "wraps": 0}
    base = {"row": sum(stages.rays[one].rows for one in range(2, shell)),
             "column": sum(stages.rays[one].columns for one in range(2, shell))}
    given = {"shell": shell, "row": base["row"] + int(rows[0]), "row_number": int(rows[0]), "rows": len(rows),
             "first_column": base["column"], "columns": rays.columns, "window": whole}
    came = BENCH.run(Schedule(
        first={"i_table": stages.tables}, items={"i": [(2, given), (0, {"rows": 0, "final": 1})]}),
        frustum=stages.ports["frustum"])["o"]
    pieces = [(item["row"] - base["row"], item["column"] - base["column"], item["count"]) for item in came[:-2]]
    spans = [np.flatnonzero(mask[row]) for row in rows]
    assert pieces == [(row, span[0], len(span)) for row, span in zip(rows, spans, strict=True)]
    return pieces


def test_rows_between_the_same_columns_are_searched_for_once():
    """The sector's arcs are others in each row."""
    stages = Quarter()
    rows = stages.rows
    pieces = check_pieces(stages, rows)
    search = documented_latency(PositionSearch, CONFIG, count=stages.rays[SHELL].columns)
    same = [one[1:] == other[1:] for one, other in pairwise(pieces)]
    assert [b - a for a, b in pairwise(BENCH.cycles["o"][:len(rows)])] == [5 if is_same else 5 + search
                                                                          for is_same in same]
    assert sum(same) > len(same) // 2


def test_a_search_serves_bounds_up_to_the_position_that_it_has_found():
    """The arc of a row begins one behind a ray with which that of the row before begins."""
    stages = Quarter()
    position = stages.rays[SHELL].column_position
    # They end with the same ray.
    row = next(row for row, later in pairwise(stages.rows) if _low(stages, later) > _low(stages, row) + 1
               and len({int((position <= _end(stages, one)).sum()) for one in (row, later)}) == 1)

    def change(rays):
        if rays.shell != SHELL:
            return rays
        changed, at = rays.column_position.copy(), _low(stages, row + 1) - 1
        changed[np.searchsorted(changed, at)] = at
        return replace(rays, column_position=changed)

    pieces = check_pieces(Quarter(change), np.array([row, row + 1]))
    assert pieces[0][1:] != pieces[1][1:]


def _low(stages, row):
    """The least position in a row."""
    return (stages.sector.first_column << 8) - int(stages.rays[SHELL].column_border[row])


def _end(stages, row):
    """The greatest one."""
    return (stages.sector.end_column << 8) + int(stages.rays[SHELL].column_border[row])
