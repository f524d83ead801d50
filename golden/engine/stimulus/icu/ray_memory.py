"""Stimulus of `golden.engine.icu.ray_memory`."""

import numpy as np

from golden.engine.icu.ray_memory import RayMemory
from golden.engine.lib.fixed import signed, unsigned
from golden.engine.stimulus.block import FLAG, Block, Field, hard_first

__all__ = ["BLOCK"]

# Few, so that updates of one ray follow each other closely.
RAYS = 64


def _fields(config):
    return [Field("rays", unsigned(23, 0), "of the frustum", constant=True),
            Field("ray", unsigned(22, 0), "whose hit it is"), Field("inverse", config.numbers.inverse, "1/t, not 0"),
            Field("patch", unsigned(31, 0), "that is hit")], [
        Field("won", FLAG, "the memory was written"),
        Field("final_inverse", config.numbers.inverse, "of each ray, 0 for no hit", constant=True),
        Field("final_patch", signed(31, 0), "of each ray, -1 for no hit", constant=True)]


def _draw(random, count, config):
    # Of neighbouring values, so that many are equal and the patch decides.
    inverse = random.integers(1, config.numbers.inverse.high, count) & ~np.where(random.random(count) < 0.5, 0xFFFF, 0)
    inverse = hard_first(np.maximum(inverse, 1), [1, 1, config.numbers.inverse.high, 1])
    ray = np.where(random.random(count) < 0.5, random.integers(RAYS, size=count), random.integers(3))
    return {"rays": np.array(RAYS), "ray": ray, "inverse": inverse, "patch": random.integers(16, size=count)}


def _expect(given, config):
    memory, won = RayMemory(int(given["rays"]), config), []
    for ray, inverse, patch in zip(given["ray"], given["inverse"], given["patch"], strict=True):
        before = memory.inverse[ray], memory.patch[ray]
        memory.update(np.array([ray]), np.array([inverse]), np.array([patch]))
        won.append((memory.inverse[ray], memory.patch[ray]) != before)
    return {"won": np.array(won), "final_inverse": memory.inverse, "final_patch": memory.patch}


BLOCK = Block(about="an update, one after the other", fields=_fields, draw=_draw, expect=_expect)
