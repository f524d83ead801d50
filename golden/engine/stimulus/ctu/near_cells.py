"""Stimulus of `golden.engine.ctu.near_cells`."""

import numpy as np

from golden.engine.ctu.unit import CellTraversalUnit
from golden.engine.stimulus.block import Block, Field, hard_first, padded
from golden.engine.stimulus.ctu.grids import CELL_NUMBER, grid_fields, random_table, table_of
from golden.engine.stimulus.frusta import frustum_arrays, frustum_fields, frustum_record, random_frustum

__all__ = ["BLOCK"]


def _fields(config):
    return [*frustum_fields(config), *grid_fields(config),
            Field("origin", config.numbers.scene, "replaces that of the frustum")], [
        Field("cells", CELL_NUMBER, "cells of shell 1, ascending, then -1")]


def _draw(random, count, config):
    record = random_frustum(random, config)
    given = random_table(random, record.origin, config)
    table = table_of(given)
    upper = table.lower + table.cell * table.shape
    origin = random.integers(np.maximum(table.lower, 0), np.minimum(upper, config.numbers.scene.high), (count, 3))
    corners = np.clip(table.lower + table.cell * random.integers(table.shape + 1, size=(8, 3)), 0,
                      config.numbers.scene.high)
    return {**frustum_arrays(record), **given, "origin": hard_first(origin, corners)}


def _expect(given, config):
    table = table_of(given)
    units = (CellTraversalUnit(frustum_record({**given, "frustum_origin": origin}, config), table)
             for origin in given["origin"])
    return {"cells": padded([unit.open(1, np.ones((unit.record.rows, unit.record.columns), dtype=bool))
                             for unit in units])}


BLOCK = Block(about="an origin in one grid of cells", fields=_fields, draw=_draw, expect=_expect)
