"""Stimulus of `golden.engine.ctu.survival`."""

import numpy as np

from golden.engine.ctu.sector import Sector
from golden.engine.ctu.settle_pyramid import SettlePyramid
from golden.engine.ctu.survival import survivors, survivors_by_code
from golden.engine.lib.fixed import unsigned
from golden.engine.stimulus.block import FLAG, Block, Field, hard_first
from golden.engine.stimulus.ctu.grid_rays import RAY, draw_rays
from golden.engine.stimulus.ctu.grids import SHELL, masks, shells
from golden.engine.stimulus.frusta import frustum_arrays, frustum_fields, frustum_record, random_frustum

__all__ = ["BLOCK"]

MASKS = 8


def _fields(config):
    return [*frustum_fields(config),
            Field("may_change", FLAG, "masks x rows x columns: the ray's hit may still change", constant=True),
            Field("mask", unsigned(4, 0), "number of the mask"),
            Field("codes", config.icu.settle, "masks x rows x columns: settle codes", constant=True),
            Field("section", RAY, "of the codes: first column, end column, first row, end row", constant=True),
            Field("threshold", unsigned(config.icu.settle_bits + 1, 0), "a ray with a smaller code may still change"),
            Field("shell", SHELL, "at least 2"), Field("row", RAY, "of the shell's grid"),
            Field("column", RAY, "of the shell's grid")], [
        Field("survives", FLAG, "a ray near the grid ray may still change"),
        Field("survives_by_code", FLAG, "a square of the section that holds rays near the grid ray is live")]


def _draw(random, count, config):
    record = random_frustum(random, config)
    may_change, high = masks(random, record, MASKS), config.icu.settle.high
    threshold = hard_first(random.integers(1, high + 1, endpoint=True, size=count), [1, high + 1])
    codes = np.where(may_change, random.integers(high // 2, size=may_change.shape),
                     random.integers(high // 2, high, endpoint=True, size=may_change.shape))
    first = random.integers([record.columns // 2, record.rows // 2])
    end = random.integers(first + 1, [record.columns, record.rows], endpoint=True)
    return {**frustum_arrays(record), "may_change": may_change, "codes": codes, "threshold": threshold,
            "section": np.stack([first, end], axis=1).ravel(), "mask": random.integers(MASKS, size=count),
            **draw_rays(random, record, count)}


def _expect(given, config):
    record = frustum_record(given, config)
    rays_of, section = shells(record), Sector(*map(int, given["section"]))
    first_column, end_column, first_row, end_row = given["section"]
    pyramids = [SettlePyramid(codes[first_row:end_row, first_column:end_column], config) for codes in given["codes"]]
    pairs, which = np.unique(np.stack([given["shell"], given["mask"]], axis=1), axis=0, return_inverse=True)
    survives, by_code = np.zeros((2, len(given["mask"])), dtype=np.int64)
    for number, (shell, mask) in enumerate(pairs):
        alive = survivors(rays_of(int(shell)), given["may_change"][mask].astype(bool))
        chosen = which == number
        survives[chosen] = alive[given["row"][chosen], given["column"][chosen]]
        for ray in np.flatnonzero(chosen):
            alive = survivors_by_code(rays_of(int(shell)), pyramids[mask], int(given["threshold"][ray]), section,
                                      record)
            by_code[ray] = alive[given["row"][ray], given["column"][ray]]
    return {"survives": survives, "survives_by_code": by_code}


BLOCK = Block(about="a grid ray and a state of one frustum's rays", fields=_fields, draw=_draw, expect=_expect)
