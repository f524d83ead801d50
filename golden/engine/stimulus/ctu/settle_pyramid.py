"""Stimulus of `golden.engine.ctu.settle_pyramid`."""

import numpy as np

from golden.engine.ctu.settle_pyramid import SettlePyramid
from golden.engine.lib.fixed import unsigned
from golden.engine.stimulus.block import FLAG, Block, Field, hard_first
from golden.engine.stimulus.ctu.grid_rays import RAY

__all__ = ["BLOCK"]


def _fields(config):
    return [Field("codes", config.icu.settle, "rows x columns: settle codes of a section", constant=True),
            Field("threshold", unsigned(config.icu.settle_bits + 1, 0), "a ray with a smaller code may still change"),
            Field("first", RAY, "column of a window, relative to the section"),
            Field("count", RAY, "columns of it"), Field("square", RAY, "column and row of a square")], [
        Field("live", FLAG, "the square has a ray that may still change"),
        Field("first_square", RAY, "of the window"), Field("end_square", RAY, "one past the last of the window")]


def _draw(random, count, config):
    high = config.icu.settle.high
    rows, columns = shape = random.integers(5, 70, size=2)
    codes = random.integers(high + 1, size=shape)
    # Squares of low codes, of high ones, and of high ones but one.
    side = 1 << config.icu.tile_bits
    for row, column in np.argwhere(random.random((rows // side, columns // side)) < 0.6) * side:
        codes[row:row + side, column:column + side] = high - random.integers(3)
        if random.random() < 0.5:
            codes[row + random.integers(side), column + random.integers(side)] = random.integers(high + 1)
    first = random.integers(columns, size=count)
    return {"codes": codes, "threshold": hard_first(random.integers(1, high + 2, size=count), [1, high + 1, high]),
            "first": first, "count": random.integers(columns - first, endpoint=True),
            "square": random.integers([-(-columns // side), -(-rows // side)], size=(count, 2))}


def _expect(given, config):
    pyramid = SettlePyramid(given["codes"], config)
    first, end = pyramid.touched(given["first"], given["count"])
    column, row = given["square"].T
    return {"live": pyramid.squares[row, column] < given["threshold"], "first_square": first, "end_square": end}


BLOCK = Block(about="a square, and a window's columns, of one section", fields=_fields, draw=_draw, expect=_expect)
