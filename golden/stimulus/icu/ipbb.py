"""Stimulus of `golden.icu.ipbb`."""

from golden.icu.edge_planes import edge_planes
from golden.icu.ipbb import ImagePlaneWindows
from golden.icu.vertex_direction import vertex_direction
from golden.stimulus.block import Block, Field
from golden.stimulus.frusta import frustum_arrays, frustum_fields, frustum_record, random_screen
from golden.stimulus.icu.edge_planes import plane_arrays, plane_fields, planes_of
from golden.stimulus.icu.window import window_arrays, window_fields
from golden.stimulus.patches import r_patches

__all__ = ["BLOCK"]


def _fields(config):
    return [*frustum_fields(config), Field("direction", config.numbers.vertex, "V' of the four vertices"),
            *plane_fields(config)], window_fields()


def _draw(random, count, config):
    direction = vertex_direction(r_patches(random, count, config.numbers), config.numbers)[0]
    return {**frustum_arrays(random_screen(random, config)), "direction": direction,
            **plane_arrays(edge_planes(direction, config.numbers))}


def _expect(given, config):
    windows = ImagePlaneWindows(frustum_record(given, config), config)
    return window_arrays(windows.windows(given["direction"], planes_of(given)))


BLOCK = Block(about="a patch, seen through one screen", fields=_fields, draw=_draw, expect=_expect)
