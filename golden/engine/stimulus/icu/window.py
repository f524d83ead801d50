"""Windows as fields of a stimulus."""

from golden.engine.icu.edge_planes import edge_planes
from golden.engine.icu.vertex_direction import vertex_direction
from golden.engine.icu.window import Window
from golden.engine.lib.fixed import unsigned
from golden.engine.stimulus.block import Arrays, Block, Field
from golden.engine.stimulus.frusta import frustum_arrays, frustum_fields, frustum_record
from golden.engine.stimulus.icu.edge_planes import plane_arrays, plane_fields, planes_of
from golden.engine.stimulus.patches import r_patches

__all__ = ["window_arrays", "window_block", "window_fields"]


def window_fields() -> list[Field]:
    """Fields of `window_arrays`."""
    return [Field(name, unsigned(17, 0), about) for name, about in (
        ("column_first", "in a hemisphere columns wrap from the last to the first"),
        ("column_count", "0 of a window without rays"), ("row_first", "the row nearest to the pole, or the uppermost"),
        ("row_count", "0 of a window without rays"))]


def window_arrays(window: Window) -> Arrays:
    """Arrays of windows."""
    return {field.name: getattr(window, field.name) for field in window_fields()}


def window_block(about: str, windows, random_frustum) -> Block:
    """The stimulus of a block that computes the windows of patches in one frustum.

    Parameters
    ----------
    windows
        Class of the block, constructed from a record and a configuration.
    random_frustum
        Function from a random generator and a configuration to a record.
    """

    def fields(config):
        return [*frustum_fields(config), Field("direction", config.numbers.vertex, "V' of the four vertices"),
                *plane_fields(config)], window_fields()

    def draw(random, count, config):
        direction = vertex_direction(r_patches(random, count, config.numbers), config.numbers)[0]
        return {**frustum_arrays(random_frustum(random, config)), "direction": direction,
                **plane_arrays(edge_planes(direction, config.numbers))}

    def expect(given, config):
        unit = windows(frustum_record(given, config), config)
        return window_arrays(unit.windows(given["direction"], planes_of(given)))

    return Block(about=about, fields=fields, draw=draw, expect=expect)
