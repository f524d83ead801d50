"""Section clip: the part of a window that belongs to the cluster's section."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import IcuFormats
from hw.lib.pipeline import Pipeline
from hw.lib.struct_stream import struct_stream

__all__ = ["SectionClip"]


class SectionClip(wiring.Component):
    """Cuts a window at the section's borders and counts from there; columns that wrap around are a second piece.

    Parameters
    ----------
    config
        The configuration.
    slot
        Shape of the sideband data. Default: a patch's slot.

    Members
    -------
    i : In, stream of ``slot``, ``window``, always ready
        `Formats.window`.
    o : Out, stream of ``slot``, ``window``, always ready
        `IcuFormats.section_window`.
    frustum : In, `Formats.frustum`
        Stable while patches are in flight, and in the cycle before.

    Timing
    ------
    Latency: ``8`` cycles. A window per cycle; nothing stalls.

    Golden counterpart: `golden.engine.icu.section_clip.section_clip`.
    """

    def __init__(self, *, config: Config, slot=None):
        formats = IcuFormats(config)
        slot = formats.slot if slot is None else slot

        super().__init__({
            "i": In(struct_stream({"slot": slot, "window": formats.window})),
            "o": Out(struct_stream({"slot": slot, "window": formats.section_window})),
            "frustum": In(formats.frustum)})
        self._pipeline = pipeline = Pipeline(self.i, self.o)
        given, made = self.i.payload.window, self.o.payload.window
        frustum, section = self.frustum, self.frustum.section

        def constant(function):
            """Of the frustum, which is stable while patches are in flight."""
            return pipeline.constant(function)

        # Registers: the sides of the section, known a cycle after the frustum.
        self._across, self._down = Signal(formats.count), Signal(formats.count)
        across, down = constant(self._across), constant(self._down)

        def not_below_zero(value):
            return Mux(value < 0, 0, value)

        def step(function, *operands):
            return pipeline.register(function, *operands)

        # A register in front: a multiplexer of two blocks' windows precedes it.
        column_first, column_count, row_first, row_count = (pipeline.delay(pipeline.input(given[name]), 1) for name in (
            "column_first", "column_count", "row_first", "row_count"))
        first = step(lambda value, origin: value - origin, column_first, constant(section.first_column))
        last = step(lambda first, count: first + count, first, column_count)
        before = pipeline.combine(lambda first: first < 0, first)
        front = step(lambda last, across: Mux(last < across, last, across), last, across)
        front = step(lambda end, first: end - first, front, first)
        front = step(lambda front, before: Mux(before, 0, not_below_zero(front)), front, before)
        over = step(lambda last, before: Mux(before, last, last - frustum.columns), last, before)
        wrapped = step(lambda over, across: Mux(over < across, over, across), over, across)
        wrapped = step(lambda wrapped, before: Mux(before | ~frustum.is_screen, not_below_zero(wrapped), 0), wrapped,
                       before)

        top = step(lambda value, origin: value - origin, row_first, constant(section.first_row))
        bottom = step(lambda top, count: top + count, top, row_count)
        top = step(not_below_zero, top)
        bottom = step(lambda bottom, down: Mux(bottom < down, bottom, down), bottom, down)
        rows = step(lambda top, bottom: bottom - top, top, bottom)

        some = pipeline.register(lambda rows, front, wrapped: (rows > 0) & ((front > 0) | (wrapped > 0)),
                                 rows, front, wrapped)

        # Compared a step ahead of the output.
        behind, starts_at_0 = pipeline.register(
            lambda front, first: (front == 0, (front == 0) | (first < 0)), front, first)

        def output(target, function, *operands):
            pipeline.output(target, step(lambda some, *values: Mux(some, function(*values), 0), some, *operands))

        output(made.column_first, lambda first, zero: Mux(zero, 0, first), first, starts_at_0)
        output(made.column_count, lambda front, wrapped, behind: Mux(behind, wrapped, front), front, wrapped, behind)
        output(made.wrapped_count, lambda wrapped, behind: Mux(behind, 0, wrapped), wrapped, behind)
        output(made.row_first, lambda top: top, top)
        output(made.row_count, lambda rows: rows, rows)
        pipeline.output(self.o.payload.slot, pipeline.input(self.i.payload.slot))
        self.latency = pipeline.latency

    def elaborate(self, platform):
        m = Module()
        self._pipeline.add_to(m)
        section = self.frustum.section
        m.d.sync += [self._across.eq(section.end_column - section.first_column),
                     self._down.eq(section.end_row - section.first_row)]
        return m
