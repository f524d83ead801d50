"""Stimulus of `golden.engine.memsys.patches.cell_table`."""

import numpy as np

from golden.engine.lib.fixed import signed, unsigned
from golden.engine.stimulus.block import Block, Field, hard_first
from golden.engine.stimulus.ctu.grids import CELL_NUMBER, grid_fields, random_table, table_of

__all__ = ["BLOCK"]

ADDRESS = unsigned(24, 0)


def _fields(config):
    return [*grid_fields(config), Field("index", unsigned(10, 0), "a cell's x, y and z")], [
        Field("lower", signed(1, config.numbers.scene_bits), "corner of the grid, G coordinates", constant=True),
        Field("shape", unsigned(10, 0), "cells along x, y and z", constant=True),
        Field("number", CELL_NUMBER, "of the cell"), Field("count", ADDRESS, "patches in it"),
        Field("pointer", ADDRESS, "its first entry of the patch address table")]


def _draw(random, count, config):
    given = random_table(random, np.full(3, 1 << config.numbers.scene_bits - 1), config)
    shape = table_of(given).shape
    return {**given, "index": hard_first(random.integers(shape, size=(count, 3)), [[0, 0, 0], shape - 1])}


def _expect(given, config):
    table = table_of(given)
    number = table.number(given["index"])
    return {"lower": table.lower, "shape": table.shape, "number": number, "count": table.count[number],
            "pointer": table.pointer[number]}


BLOCK = Block(about="a cell of one scene", fields=_fields, draw=_draw, expect=_expect)
