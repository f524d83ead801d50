"""Stimulus of `golden.engine.icu.patch_sums`."""

import numpy as np

from golden.cast.hemisphere import Hemisphere
from golden.engine.icu.patch_sums import SUM_BITS, section_sums
from golden.engine.lib.fixed import signed, unsigned
from golden.engine.stimulus.block import Block, Field, hard_first
from golden.engine.stimulus.frusta import HEMISPHERE

__all__ = ["BLOCK"]

PATCHES = 64


def _fields(config):
    return [Field("patch", signed(31, 0), "that the ray hits, or -1"),
            Field("weight", unsigned(SUM_BITS, 0), "of the ray")], [
        Field("sum_patch", signed(31, 0), "of each word, in their order", constant=True),
        Field("sum", unsigned(SUM_BITS, 0), "of its weights", constant=True)]


def _draw(random, count, config):
    hemisphere = Hemisphere(*HEMISPHERE)
    patch = np.where(random.random(count) < 0.5, random.integers(PATCHES, size=count), random.integers(PATCHES))
    return {"patch": hard_first(patch, [-1, 0, 0, PATCHES - 1, -1]), "weight": np.resize(hemisphere.weights, count)}


def _expect(given, config):
    sums = section_sums(given["patch"], given["weight"])
    return {"sum_patch": sums.patch, "sum": sums.sum}


BLOCK = Block(about="a ray, one after the other", fields=_fields, draw=_draw, expect=_expect)
