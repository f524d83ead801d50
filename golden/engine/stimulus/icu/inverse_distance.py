"""Stimulus of `golden.engine.icu.inverse_distance`."""

import numpy as np

from golden.engine.icu.inverse_distance import inverse_distance
from golden.engine.icu.plane_factor import plane_factor
from golden.engine.stimulus.block import Block, Field, hard_first
from golden.engine.stimulus.icu.plane_factor import factor_arrays, factor_fields, factor_of
from golden.engine.stimulus.patches import directions_at, r_patches

__all__ = ["BLOCK"]


def _fields(config):
    return [*factor_fields(config), Field("ray", config.numbers.direction, "direction of the ray")], [
        Field("inverse", config.numbers.inverse, "1/t: exponent and fraction; saturated, at least 1")]


def _draw(random, count, config):
    patches = r_patches(random, count, config.numbers)
    factor = factor_arrays(plane_factor(patches, config.numbers))
    # Dropped patches have no distance; some factors are of planes nearer and farther than those of any patch.
    dropped, bits = factor["dropped"], config.numbers.mantissa_bits
    factor["mantissa"][dropped] = random.integers(1 << bits - 1, 1 << bits, (dropped.sum(), 3))
    factor["factor_exponent"][dropped] = random.integers(-64, 64, dropped.sum())
    ray = directions_at(random, patches, config.numbers)
    # Along the plane and away from it.
    along = np.cross(factor["mantissa"].astype(float), [0.6, 0.0, 0.8])
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1)
    hard_first(ray, config.numbers.direction.encode(np.where(np.arange(count)[:, None] % 2, along, -along), "ray"))
    return {**factor, "dropped": np.zeros(count, dtype=np.int64), "ray": ray}


def _expect(given, config):
    return {"inverse": inverse_distance(factor_of(given), given["ray"], config.numbers)}


BLOCK = Block(about="a patch and a ray", fields=_fields, draw=_draw, expect=_expect)
