"""Stimulus of `golden.engine.memsys.patches.patch_table`."""

import numpy as np

from golden.engine.lib.fixed import unsigned
from golden.engine.stimulus.block import Block, Field, hard_first
from golden.engine.stimulus.ctu.grids import grid_fields, random_table, table_of
from golden.engine.stimulus.memsys.cell_table import ADDRESS

__all__ = ["BLOCK"]


def _fields(config):
    return [*grid_fields(config), Field("address", ADDRESS, "in the table")], [
        Field("patch", unsigned(31, 0), "the entry")]


def _draw(random, count, config):
    given = random_table(random, np.full(3, 1 << config.numbers.scene_bits - 1), config)
    size = len(table_of(given).patches)
    return {**given, "address": hard_first(random.integers(size, size=count), [0, size - 1])}


def _expect(given, config):
    return {"patch": table_of(given).patches.read(given["address"])}


BLOCK = Block(about="an address of one scene's table", fields=_fields, draw=_draw, expect=_expect)
