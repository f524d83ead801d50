"""Stimulus of `golden.engine.ctu.sector`."""

import numpy as np

from golden.engine.ctu.sector import Sector, sector_rays, subshell_rays
from golden.engine.stimulus.block import FLAG, Block, Field
from golden.engine.stimulus.ctu.grid_rays import RAY, draw_rays
from golden.engine.stimulus.ctu.grids import SHELL, shells
from golden.engine.stimulus.frusta import frustum_arrays, frustum_fields, frustum_record, random_frustum

__all__ = ["BLOCK"]


def _fields(config):
    return [*frustum_fields(config), Field("shell", SHELL, "at least 2"), Field("row", RAY, "of the shell's grid"),
            Field("column", RAY, "of the shell's grid"),
            Field("sector", RAY, "first column, end column, first row, end row of the frustum's rays"),
            Field("window", RAY, "first column, columns, first row, rows; columns of a hemisphere wrap")], [
        Field("in_sector", FLAG, "the grid ray can open cells of hits of the sector's rays"),
        Field("in_subshell", FLAG, "the grid ray passes through the window")]


def _draw(random, count, config):
    record = random_frustum(random, config)
    size = np.array([record.columns, record.rows])
    first = random.integers(size, size=(count, 2))
    end = random.integers(first + 1, size, endpoint=True)
    first[0::5], end[0::5] = 0, size
    start = random.integers(size, size=(count, 2))
    most = size - start
    if not record.is_screen:
        most[:, 0] = record.columns
    length = random.integers(1, most, endpoint=True)
    return {**frustum_arrays(record), **draw_rays(random, record, count),
            "sector": np.stack([first[:, 0], end[:, 0], first[:, 1], end[:, 1]], axis=1),
            "window": np.stack([start[:, 0], length[:, 0], start[:, 1], length[:, 1]], axis=1)}


def _expect(given, config):
    record = frustum_record(given, config)
    rays_of, found = shells(record), []
    for shell, row, column, sector, window in zip(*(given[name] for name in (
            "shell", "row", "column", "sector", "window")), strict=True):
        rays = rays_of(int(shell))
        found.append((sector_rays(rays, Sector(*map(int, sector)), record)[row, column],
                      subshell_rays(rays, window, record)[row, column]))
    in_sector, in_subshell = np.array(found).T
    return {"in_sector": in_sector, "in_subshell": in_subshell}


BLOCK = Block(about="a grid ray, a sector and a window of one frustum", fields=_fields, draw=_draw, expect=_expect)
