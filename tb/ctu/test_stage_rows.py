"""Stages come in golden's order, each with the rows of its grid that lie in sector and window."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from hw.ctu.stage_rows import StageRows
from tb.ctu.window_stages import WindowStages
from tb.lib.configurations import config_of
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.timing import documented_latency

CONFIG = config_of({"ctu.run_ahead": 15})
BENCH = ScheduleBench(StageRows(config=CONFIG), idle_limit=60)
# Of the windows as many as there may be stages in flight.
SHELLS, WINDOWS = 4, slice(0, 4)


def played(kind, *, sector, seed, items=WINDOWS, stalls=(), stages=WindowStages):
    """The stages, with the cycles."""
    stages = stages(kind, CONFIG, seed=seed, sector=sector, last_shell=SHELLS)
    stages.only(items)
    came = BENCH.run(Schedule(
        first={"i_table": stages.tables}, items={"i": [(2 * (not k), item) for k, item in enumerate(stages.items)]},
        stalls={"o": list(stalls)}), **stages.ports)["o"]
    return stages, came


def rows_of(stages, window, shell):
    """The rows of a shell's grid in sector and window: which they are."""
    rays, sector = stages.rays[shell], stages.sector
    position = rays.row_position
    inside = (position >= 256 * sector.first_row - rays.row_border) & (
        position <= 256 * sector.end_row + rays.row_border)
    if window is not None:
        inside &= (position >= 256 * window[2]) & (position < 256 * (window[2] + window[3]))
    return np.flatnonzero(inside)


@pytest.mark.parametrize(("kind", "sector", "seed", "stalls"), [
    ("hemisphere", 0, 3, ()), ("hemisphere", 1, 4, (0, 5, 30, 1)), ("screen", 2, 5, (9,) * 9),
    ("hemisphere", 4, 6, ())])
def test_rows_of_every_stage(kind, sector, seed, stalls):
    check(*played(kind, sector=sector, seed=seed, stalls=stalls))


def check(stages, came):
    """The stages are golden's, and their rows those of `rows_of`."""
    expected = list(stages.stages())
    assert [item["final"] for item in came] == [0] * len(expected) + [1]
    first_row, first_column, first_ray = 0, 0, 0
    firsts = {}
    for shell, rays in stages.rays.items():
        firsts[shell] = first_row, first_column, first_ray
        first_row, first_column = first_row + rays.rows, first_column + rays.columns
        first_ray += rays.rows * rays.columns
    for number, (item, (window, shell, _)) in enumerate(zip(came, expected, strict=False)):
        rows, rays = rows_of(stages, window, shell), stages.rays[shell]
        assert (item["stage"], item["shell"], item["rows"]) == (number % 16, shell, len(rows)), number
        assert (item["first_column"], item["first_ray"], item["columns"]) == (*firsts[shell][1:], rays.columns)
        if len(rows):
            assert (item["row"], item["row_number"]) == (firsts[shell][0] + rows[0], rows[0]), number


def test_stages_of_each_frustum_are_counted_from_the_first_number_on():
    """Whatever the frusta before had; all have the same windows here."""
    stages = WindowStages("hemisphere", CONFIG, seed=3, last_shell=SHELLS).only(slice(0, 1))
    came = BENCH.run(Schedule(
        first={"i_table": stages.tables}, items={"i": [(5, item) for item in 2 * stages.items]}), **stages.ports)["o"]
    one = [(number, shell) for number, (_, shell, _) in enumerate(stages.stages())]
    assert len(one) > 2
    assert [(item["stage"], item["shell"]) for item in came if not item["final"]] == 2 * one
    assert [item["final"] for item in came] == 2 * [*[0] * len(one), 1]


class BorderStages(WindowStages):
    """A row of each shell is at the sector's border, or ``outside`` units beyond it."""

    at_end, outside = True, 0

    def _prepare(self, record, sector, of, last_shell, config):
        def at_border(shell):
            rays = of(shell)
            if self.at_end:
                distance = rays.row_position - 256 * sector.end_row
            else:
                distance = 256 * sector.first_row - rays.row_position
            return replace(rays, row_border=int(distance[distance > 1].min()) - self.outside)

        super()._prepare(record, sector, at_border, last_shell, config)


@pytest.mark.parametrize("outside", [-1, 0, 1])
@pytest.mark.parametrize(("at_end", "sector"), [(True, 1), (False, 4)])
def test_a_row_at_the_sectors_border_is_in_the_stage(at_end, sector, outside):
    stages = type("Stages", (BorderStages,), {"at_end": at_end, "outside": outside})
    check(*played("hemisphere", sector=sector, seed=4, items=slice(0, 0), stages=stages))


def test_a_stage_after_the_latency():
    stages, came = played("hemisphere", sector=0, seed=3, items=slice(0, 0))
    assert len(came) == SHELLS
    cycles = BENCH.cycles["o"]
    latency = {shell: documented_latency(StageRows, CONFIG, rows=rays.rows) for shell, rays in stages.rays.items()}
    assert cycles[0] - BENCH.cycles["i"][0] == latency[2]
    assert [b - a for a, b in pairwise(cycles[:-1])] == [latency[shell] - 1 for shell in range(3, SHELLS + 1)]
