"""Stimulus of `golden.ctu.cell_traversal`."""

import numpy as np

from golden.ctu.cell_traversal import BEGIN_BITS, INDEX_BITS, PLACE_FRACTION, Traversal
from golden.ctu.grid_rays import FRACTION
from golden.fixed import signed, unsigned
from golden.stimulus.block import Block, Field, hard_first, padded
from golden.stimulus.ctu.grids import CELL_NUMBER, SHELLS

__all__ = ["BLOCK"]


def _fields(config):
    parameter = unsigned(BEGIN_BITS - PLACE_FRACTION, PLACE_FRACTION)
    return [Field("place", signed(INDEX_BITS - 1, PLACE_FRACTION), "origin in cells, from the grid's lower corner",
                  constant=True),
            Field("shape", unsigned(10, 0), "cells along x, y and z", constant=True),
            Field("begin", parameter, "parameter at which the shell begins", constant=True),
            Field("end", parameter, "parameter at which it ends", constant=True),
            Field("direction", signed(4, FRACTION), "G coordinates")], [
        Field("cells", CELL_NUMBER, "(x shape_y + y) shape_z + z in the order in which they are met, then -1")]


def _draw(random, count, config):
    one, shape = 1 << PLACE_FRACTION, random.integers(6, 12, 3)
    # Inside a cell, on its corner, or outside the grid.
    place = [random.integers(one * shape), random.integers(shape) * one, -random.integers(2 * one, size=3)][
        random.integers(3)]
    shell = int(random.integers(*SHELLS))
    direction = random.normal(size=(count, 3))
    # Along axes, and through edges and corners of cells.
    hard = np.array([[x, y, z] for x in (1, 0, -1) for y in (1, 0, -1) for z in (1, 0, -1) if x or y or z], dtype=float)
    direction = hard_first(direction, hard)
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    # Of a wide screen parameters are longer than ways.
    stretch = [1, random.uniform(1, 12)][random.integers(2)]
    begin, end = (int(border * stretch * one) for border in (shell - 1, shell))
    return {"place": place, "shape": shape, "begin": np.array(begin), "end": np.array(end),
            "direction": signed(1, FRACTION).encode(direction, "direction")}


def _expect(given, config):
    shape = given["shape"]
    walk = Traversal(given["place"], given["direction"], begin=int(given["begin"]), end=int(given["end"]), shape=shape)
    cells = [[] for _ in given["direction"]]
    while len(walk.ray):
        inside = walk.inside
        x, y, z = walk.index[inside].T
        for ray, met in zip(walk.ray[inside], (x * shape[1] + y) * shape[2] + z, strict=True):
            cells[ray].append(met)
        walk.advance()
    return {"cells": padded(cells)}


BLOCK = Block(about="a grid ray through one shell", fields=_fields, draw=_draw, expect=_expect)
