"""Stimulus of `golden.engine.ctu.unit`."""

import numpy as np

from golden.engine.ctu.sector import Sector
from golden.engine.ctu.unit import CellTraversalUnit
from golden.engine.stimulus.block import FLAG, Block, Field, padded
from golden.engine.stimulus.ctu.grid_rays import RAY
from golden.engine.stimulus.ctu.grids import CELL_NUMBER, SHELL, grid_fields, masks, random_table, table_of
from golden.engine.stimulus.frusta import frustum_arrays, frustum_fields, frustum_record, random_frustum

__all__ = ["BLOCK"]

MOST_SHELLS = 12


def _fields(config):
    return [*frustum_fields(config), *grid_fields(config),
            Field("shell", SHELL, "shell to open: ascending from 1, then again from 1 for another state of the rays"),
            Field("may_change", FLAG, "rows x columns: the ray's hit may still change"),
            Field("sector", RAY, "first column, end column, first row, end row")], [
        Field("cells", CELL_NUMBER, "pass by pass (one step of each grid ray), with repetitions, then -1")]


def _draw(random, count, config):
    record = random_frustum(random, config)
    half = [[0, record.columns, 0, record.rows], [0, record.columns // 2, 0, record.rows],
            [record.columns // 4, record.columns, record.rows // 2, record.rows]]
    number = np.arange(count)
    return {**frustum_arrays(record), **random_table(random, record.origin, config),
            "shell": number % MOST_SHELLS + 1, "may_change": masks(random, record, count),
            "sector": np.array(half)[number // MOST_SHELLS % 3]}


def _expect(given, config):
    record, table, cells = frustum_record(given, config), table_of(given), []
    for shell, may_change, sector in zip(given["shell"], given["may_change"], given["sector"], strict=True):
        unit = CellTraversalUnit(record, table, Sector(*map(int, sector)))
        cells.append(unit.open(int(shell), may_change.astype(bool)))
    return {"cells": padded(cells)}


BLOCK = Block(about="a shell of one frustum and a state of its rays", fields=_fields, draw=_draw, expect=_expect)
