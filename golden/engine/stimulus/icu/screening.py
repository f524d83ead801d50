"""Stimulus of `golden.engine.icu.screening`."""

from golden.engine.icu.edge_planes import edge_planes
from golden.engine.icu.screening import edge_distances, inside
from golden.engine.icu.vertex_direction import vertex_direction
from golden.engine.lib.fixed import signed
from golden.engine.stimulus.block import FLAG, Block, Field
from golden.engine.stimulus.icu.edge_planes import plane_arrays, plane_fields, planes_of
from golden.engine.stimulus.patches import directions_at, r_patches

__all__ = ["BLOCK"]


def _fields(config):
    return [*plane_fields(config), Field("ray", config.numbers.direction, "direction of the ray")], [
        Field("distances", config.numbers.edge_distance, "planes times ray"),
        Field("inside", FLAG, "the ray is inside the edges"),
        Field("held", signed(1, 0), "the orientation for which it is inside; else that of the first triangle, or "
                                    "(split) of the second")]


def _draw(random, count, config):
    patches = r_patches(random, count, config.numbers)
    planes = edge_planes(vertex_direction(patches, config.numbers)[0], config.numbers)
    return {**plane_arrays(planes), "ray": directions_at(random, patches, config.numbers)}


def _expect(given, config):
    planes = planes_of(given)
    distances = edge_distances(planes, given["ray"], config.numbers)
    is_inside, held = inside(distances, planes)
    return {"distances": distances, "inside": is_inside, "held": held}


BLOCK = Block(about="a patch and a ray", fields=_fields, draw=_draw, expect=_expect)
