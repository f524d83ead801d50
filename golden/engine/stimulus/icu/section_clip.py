"""Stimulus of `golden.engine.icu.section_clip`."""

import numpy as np

from golden.engine.ctu.sector import Sector
from golden.engine.frustum import FrustumRecord
from golden.engine.icu.section_clip import section_clip
from golden.engine.icu.window import Window
from golden.engine.lib.fixed import unsigned
from golden.engine.stimulus.block import Block, Field
from golden.engine.stimulus.frusta import frustum_arrays, frustum_fields, frustum_record, random_frustum
from golden.engine.stimulus.icu.window import window_arrays, window_fields

__all__ = ["BLOCK", "draw_windows"]

COUNT = unsigned(17, 0)


def draw_windows(random: np.random.Generator, record: FrustumRecord, count: int) -> Window:
    """Random windows, many of which wrap in a hemisphere; the first eight are as wide as possible."""
    first, rows = random.integers(record.columns, size=count), random.integers(record.rows, size=count)
    most = record.columns - first if record.is_screen else np.full(count, record.columns)
    columns = random.integers(0, most + 1)
    columns[:8] = most[:8]
    return Window(first, columns, rows, random.integers(0, record.rows - rows + 1))


def _fields(config):
    return [*frustum_fields(config),
            Field("section", COUNT, "first column, end column, first row, end row", constant=True), *window_fields()], [
        Field("part_column_first", COUNT, "relative to the section's first column"),
        Field("part_column_count", COUNT, "columns from part_column_first"),
        Field("part_wrapped_count", COUNT, "further columns, from the section's first"),
        Field("part_row_first", COUNT, "relative to the section's first row"),
        Field("part_row_count", COUNT, "0 of a window without rays in the section")]


def _draw(random, count, config):
    record = random_frustum(random, config)
    size = np.array([record.columns, record.rows])
    first = random.integers(size)
    end = random.integers(first + 1, size, endpoint=True)
    return {**frustum_arrays(record), "section": np.stack([first, end], axis=1).ravel(),
            **window_arrays(draw_windows(random, record, count))}


def _expect(given, config):
    window = Window(*(given[field.name] for field in window_fields()))
    parts = section_clip(window, Sector(*map(int, given["section"])), frustum_record(given, config))
    return {f"part_{name}": value for name, value in vars(parts).items()}


BLOCK = Block(about="a window and the section of one frustum", fields=_fields, draw=_draw, expect=_expect)
