"""Stimulus of `golden.engine.icu.g2r_transform`."""

from golden.engine.icu.g2r_transform import g2r_transform
from golden.engine.stimulus.block import Block, Field, hard_first
from golden.engine.stimulus.frusta import frustum_arrays, frustum_fields, frustum_record, random_frustum

__all__ = ["BLOCK"]


def _fields(config):
    return [*frustum_fields(config), Field("vertex", config.numbers.scene, "G coordinates")], [
        Field("transformed", config.numbers.vector, "the vertex in the R frame")]


def _draw(random, count, config):
    record, high = random_frustum(random, config), config.numbers.scene.high
    drawn = random.integers(0, high, (count, 3), endpoint=True)
    corners = [[x, y, z] for x in (0, high) for y in (0, high) for z in (0, high)]
    return {**frustum_arrays(record), "vertex": hard_first(drawn, [record.origin, *corners, record.origin + 1])}


def _expect(given, config):
    return {"transformed": g2r_transform(frustum_record(given, config), given["vertex"])}


BLOCK = Block(about="a vertex, seen from one frustum", fields=_fields, draw=_draw, expect=_expect)
