"""Stimulus of `golden.engine.icu.edge_planes`."""

from golden.engine.icu.edge_planes import EdgePlanes, edge_planes
from golden.engine.icu.vertex_direction import vertex_direction
from golden.engine.lib.fixed import signed
from golden.engine.stimulus.block import FLAG, Arrays, Block, Field
from golden.engine.stimulus.patches import r_patches

__all__ = ["BLOCK", "plane_arrays", "plane_fields", "planes_of"]


def plane_fields(config) -> list[Field]:
    """Fields of `plane_arrays`."""
    return [Field("planes", config.numbers.edge_plane, "V'_i x V'_j of 01, 12, 23, 30, 02, 13"),
            Field("orientation", signed(1, 0), "of the triangles 012 and 023: -1, 0 or 1"),
            Field("split", FLAG, "the patch is tested as its two triangles")]


def plane_arrays(planes: EdgePlanes) -> Arrays:
    """Arrays of edge planes."""
    return {"planes": planes.planes, "orientation": planes.orientation, "split": planes.split}


def planes_of(given: Arrays) -> EdgePlanes:
    """The edge planes of their arrays."""
    return EdgePlanes(given["planes"], given["orientation"], given["split"].astype(bool))


def _fields(config):
    return [Field("direction", config.numbers.vertex, "V' of the four vertices; a triangle's last one twice")], \
        plane_fields(config)


def _draw(random, count, config):
    return {"direction": vertex_direction(r_patches(random, count, config.numbers), config.numbers)[0]}


def _expect(given, config):
    return plane_arrays(edge_planes(given["direction"], config.numbers))


BLOCK = Block(about="a patch", fields=_fields, draw=_draw, expect=_expect)
