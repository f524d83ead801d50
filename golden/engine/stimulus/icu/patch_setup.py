"""Stimulus of `golden.engine.icu.patch_setup`."""

import numpy as np

from golden.engine.icu.patch_setup import PatchSetup
from golden.engine.lib.fixed import signed
from golden.engine.scene.g_coordinates import GCoordinates
from golden.engine.scene.patch_geometry import PatchGeometry
from golden.engine.stimulus.block import FLAG, Block, Field
from golden.engine.stimulus.frusta import SOURCE, frustum_arrays, frustum_fields, frustum_record, random_frustum
from golden.engine.stimulus.icu.edge_planes import plane_arrays, plane_fields
from golden.engine.stimulus.icu.plane_factor import factor_arrays, factor_fields
from golden.engine.stimulus.icu.vertex_direction import EXPONENT
from golden.engine.stimulus.icu.window import window_arrays, window_fields
from golden.engine.stimulus.patches import scene_patches

__all__ = ["BLOCK"]


def _fields(config):
    numbers = config.numbers
    return [*frustum_fields(config), Field("vertices", numbers.scene, "G coordinates; a triangle's last one twice"),
            Field("surface", signed(31, 0), "surface of the patch")], [
        Field("exponents", EXPONENT, "of the four V'"), *plane_fields(config), *factor_fields(config),
        *window_fields(), Field("bound", numbers.inverse, "no ray of the window has a larger 1/t"),
        Field("live", FLAG, "the patch can be hit")]


def _draw(random, count, config):
    record = random_frustum(random, config)
    return {**frustum_arrays(record), "vertices": scene_patches(random, count, record.origin, config.numbers),
            "surface": random.integers(0, 4 * SOURCE, count)}


def _expect(given, config):
    box = np.array([[0.0] * 3, [1.0] * 3])
    coordinates = GCoordinates(corner=np.zeros(3), scale=1.0, numbers=config.numbers, bounds=box)
    geometry = PatchGeometry(coordinates=coordinates, vertices=given["vertices"], surface=given["surface"])
    patches = PatchSetup(frustum_record(given, config), config).patches(geometry)
    return {"exponents": patches.exponents, **plane_arrays(patches.planes), **factor_arrays(patches.factor),
            **window_arrays(patches.window), "bound": patches.bound, "live": patches.live}


BLOCK = Block(about="a patch, seen from one frustum", fields=_fields, draw=_draw, expect=_expect)
