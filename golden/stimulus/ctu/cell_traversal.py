"""Stimulus of `golden.ctu.cell_traversal`."""

import numpy as np

from golden.ctu.cell_traversal import Traversal
from golden.ctu.grid_rays import FRACTION
from golden.fixed import signed, unsigned
from golden.stimulus.block import Block, Field, hard_first, padded
from golden.stimulus.ctu.grids import CELL_NUMBER, SHELLS

__all__ = ["BLOCK"]


def _fields(config):
    bits = config.numbers.scene_bits
    place = signed(1, bits)
    return [Field("origin", place, "G coordinates", constant=True),
            Field("lower", place, "lower corner of the grid", constant=True),
            Field("cell", unsigned(1, bits), "side of a cell", constant=True),
            Field("shape", unsigned(10, 0), "cells along x, y and z", constant=True),
            Field("begin", unsigned(4, bits), "parameter at which the shell begins", constant=True),
            Field("end", unsigned(4, bits), "parameter at which it ends", constant=True),
            Field("direction", signed(1, FRACTION), "G coordinates")], [
        Field("cells", CELL_NUMBER, "(x shape_y + y) shape_z + z in the order in which they are met, then -1")]


def _draw(random, count, config):
    side = 1 << config.numbers.scene_bits
    cell, shape = int(side * random.uniform(0.03, 0.09)), random.integers(6, 12, 3)
    lower = random.integers(side // 16, side // 8, 3)
    # Inside a cell, on its corner, or outside the grid.
    inside = lower + random.integers(cell * shape)
    origin = [inside, lower + random.integers(shape) * cell, lower - random.integers(2 * cell, size=3)][
        random.integers(3)]
    shell = int(random.integers(*SHELLS))
    direction = random.normal(size=(count, 3))
    # Along axes, and through edges and corners of cells.
    hard = np.array([[x, y, z] for x in (1, 0, -1) for y in (1, 0, -1) for z in (1, 0, -1) if x or y or z], dtype=float)
    direction = hard_first(direction, hard)
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    return {"origin": origin, "lower": lower, "cell": np.array(cell), "shape": shape,
            "begin": np.array((shell - 1) * cell), "end": np.array(shell * cell),
            "direction": signed(1, FRACTION).encode(direction, "direction")}


def _expect(given, config):
    shape = given["shape"]
    walk = Traversal(given["origin"], given["direction"], begin=int(given["begin"]), end=int(given["end"]),
                     lower=given["lower"], cell=int(given["cell"]), shape=shape)
    cells = [[] for _ in given["direction"]]
    while len(walk.ray):
        number = (walk.index[:, 0] * shape[1] + walk.index[:, 1]) * shape[2] + walk.index[:, 2]
        for ray, met in zip(walk.ray, number, strict=True):
            cells[ray].append(met)
        walk.advance()
    return {"cells": padded(cells)}


BLOCK = Block(about="a grid ray through one shell", fields=_fields, draw=_draw, expect=_expect)
