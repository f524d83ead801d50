"""Stimulus of `golden.ctu.survival`."""

import numpy as np

from golden.ctu.survival import survivors
from golden.fixed import unsigned
from golden.stimulus.block import FLAG, Block, Field
from golden.stimulus.ctu.grid_rays import RAY, draw_rays
from golden.stimulus.ctu.grids import SHELL, mask_fields, masks, shells
from golden.stimulus.frusta import frustum_arrays, frustum_fields, frustum_record, random_frustum

__all__ = ["BLOCK"]

MASKS = 8


def _fields(config):
    return [*frustum_fields(config), *mask_fields(), Field("mask", unsigned(4, 0), "which of them"),
            Field("shell", SHELL, "from 2 on"), Field("row", RAY, "of the shell's grid"),
            Field("column", RAY, "of the shell's grid")], [
        Field("survives", FLAG, "some ray near the grid ray may still change")]


def _draw(random, count, config):
    record = random_frustum(random, config)
    return {**frustum_arrays(record), "may_change": masks(random, record, MASKS),
            "mask": random.integers(MASKS, size=count), **draw_rays(random, record, count)}


def _expect(given, config):
    rays_of = shells(frustum_record(given, config))
    pairs, which = np.unique(np.stack([given["shell"], given["mask"]], axis=1), axis=0, return_inverse=True)
    survives = np.zeros(len(given["mask"]), dtype=np.int64)
    for number, (shell, mask) in enumerate(pairs):
        alive = survivors(rays_of(int(shell)), given["may_change"][mask].astype(bool))
        asked = which == number
        survives[asked] = alive[given["row"][asked], given["column"][asked]]
    return {"survives": survives}


BLOCK = Block(about="a grid ray and a state of one frustum's rays", fields=_fields, draw=_draw, expect=_expect)
