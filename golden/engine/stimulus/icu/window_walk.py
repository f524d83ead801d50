"""Stimulus of `golden.engine.icu.window_walk`."""

from golden.engine.icu.section_clip import SectionWindow
from golden.engine.icu.window_walk import ray_address, walk_cycles, window_tiles
from golden.engine.lib.fixed import unsigned
from golden.engine.stimulus.block import Block, Field
from golden.engine.stimulus.icu import section_clip

__all__ = ["BLOCK"]

COUNT = unsigned(17, 0)
PARTS = ("column_first", "column_count", "wrapped_count", "row_first", "row_count")


def _fields(config):
    return [Field("tiles_across", COUNT, "tiles in a row of tiles of the section", constant=True),
            *(Field(name, COUNT, "see icu.section_clip, part_" + name) for name in PARTS),
            Field("live", unsigned(34, 0), "rays of the window that may improve"),
            Field("column", COUNT, "of a ray, relative to the section's first column"),
            Field("row", COUNT, "of a ray, relative to the section's first row")], [
        Field("tiles", unsigned(34, 0), "words of the settle map that the scan reads"),
        Field("cycles", unsigned(34, 0), "of the window's scan"),
        Field("address", unsigned(34, 0), "of the ray in the ray memory")]


def _draw(random, count, config):
    clip = section_clip.BLOCK
    given = clip.draw(random, count, config)
    parts = clip.expect(given, config)
    window = {name: parts["part_" + name] for name in PARTS}
    first_column, end_column, first_row, end_row = given["section"]
    return {"tiles_across": -(-(end_column - first_column) >> config.icu.tile_bits), **window,
            "live": random.integers(0, SectionWindow(**window).rays, endpoint=True),
            "column": random.integers(end_column - first_column, size=count),
            "row": random.integers(end_row - first_row, size=count)}


def _expect(given, config):
    window = SectionWindow(**{name: given[name] for name in PARTS})
    return {"tiles": window_tiles(window, config.icu), "cycles": walk_cycles(window, given["live"], config.icu),
            "address": ray_address(given["column"], given["row"], int(given["tiles_across"]), config.icu)}


BLOCK = Block(about="a window in its section, and a ray of the section", fields=_fields, draw=_draw, expect=_expect)
