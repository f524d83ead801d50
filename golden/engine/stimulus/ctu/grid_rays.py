"""Stimulus of `golden.engine.ctu.grid_rays`."""

import numpy as np

from golden.engine.ctu.grid_rays import FRACTION, INDEX_FRACTION
from golden.engine.ctu.unit import global_directions
from golden.engine.lib.fixed import signed, unsigned
from golden.engine.stimulus.block import Block, Field
from golden.engine.stimulus.ctu.grids import SHELL, SHELLS, shells
from golden.engine.stimulus.frusta import frustum_arrays, frustum_fields, frustum_record, random_frustum

__all__ = ["BLOCK", "RAY", "draw_rays"]

RAY = unsigned(16, 0)


def draw_rays(random: np.random.Generator, record, count: int) -> dict[str, np.ndarray]:
    """Shell, row and column of grid rays; those at the corners of the grids are first."""
    shell = random.integers(*SHELLS, count, endpoint=True)
    size = np.array([(rays.rows, rays.columns) for rays in map(shells(record), shell.tolist())])
    entry = random.integers(size)
    corners = (count + 1) // 2
    entry[:min(corners, 8):2] = 0
    entry[1:min(corners, 8):2] = size[1:min(corners, 8):2] - 1
    return {"shell": shell, "row": entry[:, 0], "column": entry[:, 1]}


def _fields(config):
    position = signed(17, INDEX_FRACTION)
    return [*frustum_fields(config), Field("shell", SHELL, "at least 2"), Field("row", RAY, "of the shell's grid"),
            Field("column", RAY, "of the shell's grid")], [
        Field("direction", signed(1, FRACTION), "see GridRays"),
        Field("global_direction", signed(2, FRACTION), "G coordinates"),
        Field("first_row", RAY, "of the rays near it"), Field("row_count", RAY, "of the rays near it"),
        Field("first_column", RAY, "of the rays near it; in a hemisphere they wrap around the circle"),
        Field("column_count", RAY, "of the rays near it"),
        Field("row_position", position, "position among the frustum's rows"),
        Field("column_position", position, "position among the frustum's columns")]


def _draw(random, count, config):
    record = random_frustum(random, config)
    return {**frustum_arrays(record), **draw_rays(random, record, count)}


def _expect(given, config):
    record, found = frustum_record(given, config), []
    rays_of = shells(record)
    for shell, row, column in zip(given["shell"], given["row"], given["column"], strict=True):
        rays = rays_of(int(shell))
        found.append((*rays.direction[row, column], rays.first_row[row], rays.row_count[row],
                      rays.first_column[row, column], rays.column_count[row, column], rays.row_position[row],
                      rays.column_position[column]))
    found = np.array(found)
    names = [field.name for field in _fields(config)[1]]
    return {"direction": found[:, :3], "global_direction": global_directions(found[:, :3], record),
            **dict(zip(names[2:], found[:, 3:].T, strict=True))}


BLOCK = Block(about="a grid ray of one frustum", fields=_fields, draw=_draw, expect=_expect)
