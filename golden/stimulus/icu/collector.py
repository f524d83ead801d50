"""Stimulus of `golden.icu.collector`."""

import numpy as np

from golden.fixed import signed, unsigned
from golden.frustum import Hemisphere
from golden.icu.collector import collect
from golden.stimulus.block import Block, Field, hard_first
from golden.stimulus.frusta import HEMISPHERE

__all__ = ["BLOCK"]

PATCHES = 64


def _fields(config):
    return [Field("patches", unsigned(31, 0), "of the scene", constant=True),
            Field("patch", signed(31, 0), "that the ray hits, or -1"),
            Field("weight", unsigned(41, 0), "of the ray")], [
        Field("sums", unsigned(62, 0), "of the weights, per patch", constant=True)]


def _draw(random, count, config):
    hemisphere = Hemisphere(*HEMISPHERE)
    patch = np.where(random.random(count) < 0.5, random.integers(PATCHES, size=count), random.integers(PATCHES))
    return {"patches": np.array(PATCHES), "patch": hard_first(patch, [-1, 0, 0, PATCHES - 1, -1]),
            "weight": np.resize(hemisphere.weights, count)}


def _expect(given, config):
    return {"sums": collect(given["patch"], given["weight"], int(given["patches"]))}


BLOCK = Block(about="a ray, one after the other", fields=_fields, draw=_draw, expect=_expect)
