"""Stimulus of `golden.engine.ctu.cell_traversal`."""

import numpy as np

from golden.engine.ctu.cell_traversal import BEGIN_BITS, INDEX_BITS, POSITION_FRACTION, Traversal
from golden.engine.ctu.grid_rays import FRACTION
from golden.engine.lib.fixed import signed, unsigned
from golden.engine.stimulus.block import Block, Field, hard_first, padded
from golden.engine.stimulus.ctu.grids import CELL_NUMBER, SHELLS

__all__ = ["BLOCK"]

# Shen & Deprettere's sequences: start in a cell, and direction.
PAPER_ORIGINS, PAPER_DIRECTIONS = [[0.5, 0.5, 0.5], [0.25, 0.5, 0.5]], [[3, 2, 1], [1, 1, 0], [1, 0, -1]]


def _fields(config):
    parameter = unsigned(BEGIN_BITS - POSITION_FRACTION, POSITION_FRACTION)
    return [Field("place", signed(INDEX_BITS - 1, POSITION_FRACTION), "origin in cells, from the grid's lower corner",
                  constant=True),
            Field("shape", unsigned(10, 0), "cells along x, y and z", constant=True),
            Field("begin", parameter, "parameter at which the shell begins", constant=True),
            Field("end", parameter, "parameter at which the shell ends", constant=True),
            Field("direction", signed(4, FRACTION), "G coordinates")], [
        Field("cells", CELL_NUMBER, "(x shape_y + y) shape_z + z in the order in which the ray meets them, then -1")]


def _draw(random, count, config):
    one, shape = 1 << POSITION_FRACTION, random.integers(6, 12, 3)
    inside = random.integers(one * shape)
    # Inside a cell, on its corner, on its edge or face, on the grid's border, outside the grid.
    kind = int(random.integers(7))
    position = [inside, random.integers(shape) * one, np.where(random.random(3) < 0.5, inside // one * one, inside),
             np.where(np.arange(3) == random.integers(3), random.integers(2) * shape * one, inside),
             -random.integers(2 * one, size=3), *((np.array(PAPER_ORIGINS) + shape // 2) * one).astype(np.int64)][kind]
    # The sequences of the paper begin at the origin itself.
    shell = 1 if kind > 4 else int(random.integers(*SHELLS))
    direction = random.normal(size=(count, 3))
    # Along axes, and through edges and corners of cells.
    hard = np.array([[x, y, z] for x in (1, 0, -1) for y in (1, 0, -1) for z in (1, 0, -1) if x or y or z], dtype=float)
    direction = hard_first(direction, np.concatenate([PAPER_DIRECTIONS, hard]))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    # On a wide screen parameters are longer than distances.
    slope_scale = 6 if kind > 4 else [1, random.uniform(1, 12)][random.integers(2)]
    begin, end = (int(border * slope_scale * one) for border in (shell - 1, shell))
    return {"place": position, "shape": shape, "begin": np.array(begin), "end": np.array(end),
            "direction": signed(1, FRACTION).encode(direction, "direction")}


def _expect(given, config):
    shape = given["shape"]
    traversal = Traversal(given["place"], given["direction"], begin=int(given["begin"]), end=int(given["end"]),
                          shape=shape)
    cells = [[] for _ in given["direction"]]
    while len(traversal.ray):
        inside = traversal.inside
        x, y, z = traversal.index[inside].T
        for ray, met in zip(traversal.ray[inside], (x * shape[1] + y) * shape[2] + z, strict=True):
            cells[ray].append(met)
        traversal.advance()
    return {"cells": padded(cells)}


BLOCK = Block(about="a grid ray through one shell", fields=_fields, draw=_draw, expect=_expect)
