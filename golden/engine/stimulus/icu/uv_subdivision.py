"""Stimulus of `golden.engine.icu.uv_subdivision`."""

from golden.engine.icu.edge_planes import edge_planes
from golden.engine.icu.screening import edge_distances, inside
from golden.engine.icu.uv_subdivision import align, uv_subdivision
from golden.engine.icu.vertex_direction import vertex_direction
from golden.engine.lib.fixed import signed
from golden.engine.stimulus.block import Block, Field
from golden.engine.stimulus.icu.vertex_direction import EXPONENT
from golden.engine.stimulus.patches import meeting_pairs

__all__ = ["BLOCK"]


def _fields(config):
    icu = config.icu
    return [Field("distances", config.numbers.edge_distance, "of a ray inside the patch to its planes"),
            Field("exponents", EXPONENT, "of the four V'"),
            Field("held", signed(1, 0), "orientation for which the ray is inside")], [
        Field("aligned", signed(2 * icu.uv_bits + icu.uv_guard + 1, 0), "the distances at one exponent"),
        Field("u", icu.uv, "step of the patch's lattice"), Field("v", icu.uv, "step of the patch's lattice")]


def _draw(random, count, config):
    patches, ray = meeting_pairs(random, count, config)
    directions, exponents = vertex_direction(patches, config.numbers)
    planes = edge_planes(directions, config.numbers)
    distances = edge_distances(planes, ray, config.numbers)
    return {"distances": distances, "exponents": exponents, "held": inside(distances, planes)[1]}


def _expect(given, config):
    aligned = align(given["distances"], given["exponents"], config.icu)
    u, v = uv_subdivision(aligned, given["held"], config.icu)
    return {"aligned": aligned, "u": u, "v": v}


BLOCK = Block(about="a hit", fields=_fields, draw=_draw, expect=_expect)
