"""Stimulus of `golden.engine.icu.intersection`."""

import numpy as np

from golden.engine.icu.edge_planes import edge_planes
from golden.engine.icu.intersection import hit_uv, intersect
from golden.engine.icu.patch_setup import Patches
from golden.engine.icu.plane_factor import plane_factor
from golden.engine.icu.vertex_direction import vertex_direction
from golden.engine.icu.window import Window
from golden.engine.stimulus.block import FLAG, Block, Field
from golden.engine.stimulus.icu.edge_planes import plane_arrays, plane_fields, planes_of
from golden.engine.stimulus.icu.plane_factor import factor_arrays, factor_fields, factor_of
from golden.engine.stimulus.icu.vertex_direction import EXPONENT
from golden.engine.stimulus.patches import directions_at, r_patches

__all__ = ["BLOCK"]


def _fields(config):
    numbers, icu = config.numbers, config.icu
    return [Field("exponents", EXPONENT, "of the four V'"), *plane_fields(config), *factor_fields(config),
            Field("live", FLAG, "the patch can be hit"), Field("ray", numbers.direction, "direction of the ray")], [
        Field("hit", FLAG, "the ray meets the patch"),
        Field("inverse", numbers.inverse, "1/t, 0 where there is no hit"),
        Field("u", icu.uv, "0 where there is no hit"), Field("v", icu.uv, "0 where there is no hit")]


def _draw(random, count, config):
    numbers = config.numbers
    patches = r_patches(random, count, numbers)
    directions, exponents = vertex_direction(patches, numbers)
    planes, factor = edge_planes(directions, numbers), plane_factor(patches, numbers)
    live = ~factor.dropped & planes.orientation.any(axis=1) & (np.arange(count) % 16 != 5)
    return {"exponents": exponents, **plane_arrays(planes), **factor_arrays(factor), "live": live,
            "ray": directions_at(random, patches, numbers)}


def _expect(given, config):
    count = len(given["live"])
    nothing = np.zeros(count, dtype=np.int64)
    patches = Patches(given["exponents"], planes_of(given), factor_of(given), Window(*[nothing] * 4), nothing,
                      given["live"].astype(bool))
    which = np.arange(count)
    pair, stored = intersect(patches, which, given["ray"], config)
    hit, inverse, u, v = np.zeros((4, count), dtype=np.int64)
    hit[pair], inverse[pair] = 1, stored
    u[pair], v[pair] = hit_uv(patches, which[pair], given["ray"][pair], config)
    return {"hit": hit, "inverse": inverse, "u": u, "v": v}


BLOCK = Block(about="a patch and a ray", fields=_fields, draw=_draw, expect=_expect)
