"""Window walk: the tiles of a window, one per cycle, and which of their rays lie in it."""

from amaranth.hdl import Cat, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import IcuFormats
from hw.lib.fixed import small_product
from hw.lib.pipeline import Pipeline
from hw.lib.skid_buffer import SkidBuffer

__all__ = ["WindowWalk"]


class WindowWalk(wiring.Component):
    """Row of tiles by row of tiles, in each the window's first piece and then the one that wraps around.

    A window without rays is one step without rays.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `IcuFormats.patch_window`
        Windows of patches.
    o : Out, stream of `IcuFormats.tile_step`
        Their tiles.
    tiles_across : In, `Formats.count`
        Tiles in a row of tiles of the section; stable while windows are in flight.

    Timing
    ------
    Latency: ``bits(side_bits - tile_bits) + 4`` cycles from a window to its first step, ``bits(n)`` those of the number
    n. One step per cycle, also from one window to the next; stalls with ``o``.

    Golden counterpart: `golden.engine.icu.window_walk.window_rays`. Source: Shen 1993, section 5.3.5.
    """

    def __init__(self, *, config: Config):
        self._config = config
        formats = IcuFormats(config)
        side, index = config.icu.tile_bits, formats.index
        super().__init__({"i": In(stream.Signature(formats.patch_window)),
                          "o": Out(stream.Signature(formats.tile_step)),
                          "tiles_across": In(formats.count)})
        # Known of a window before its first step: ``some`` rays, a piece that wraps (``round``), and of columns,
        # wrapped columns and rows the last one, the tile before its own, and whether the first tile is the last.
        tile = config.icu.side_bits - side
        extent = StructLayout({"last": index, "before": tile, "single": 1})
        self._window = StructLayout({
            "slot": formats.slot, "threshold": formats.threshold, "some": 1, "round": 1,
            "column_first": index, "row_first": index, "columns": extent, "wrapped": extent, "rows": extent,
            "base": formats.tile})
        # A register: whether the next window is accepted is known late.
        self._next = SkidBuffer(self._window)
        self._pipeline = pipeline = Pipeline(self.i, self._next.i, ready_next=self._next.ready_next)
        given, made = self.i.payload, self._next.i.payload
        window = given.window

        def add_extent(target, first, count):
            first = pipeline.constant(Const(0, index)) if first is None else pipeline.input(first)
            last = pipeline.register(lambda first, count: (first + count - 1)[:config.icu.side_bits], first,
                                     pipeline.input(count))
            pipeline.output(target.last, last)
            pipeline.output(target.before, pipeline.register(lambda last: (last[side:] - 1)[:tile], last))
            pipeline.output(target.single, pipeline.register(lambda first, last: first[side:] == last[side:], first,
                                                             last))

        add_extent(made.columns, window.column_first, window.column_count)
        add_extent(made.wrapped, None, window.wrapped_count)
        add_extent(made.rows, window.row_first, window.row_count)
        row_first = pipeline.input(window.row_first)
        some = pipeline.register(lambda rows, columns: rows.any() & columns.any(), pipeline.input(window.row_count),
                                 pipeline.input(window.column_count))
        base = small_product(pipeline, pipeline.combine(lambda row: Cat(row[side:], 0).as_signed(), row_first),
                             pipeline.constant(Cat(self.tiles_across, 0).as_signed()))
        for name, value in (
                ("slot", pipeline.input(given.slot)), ("threshold", pipeline.input(given.threshold)),
                ("some", some), ("round", pipeline.input(window.wrapped_count.any())),
                ("column_first", pipeline.input(window.column_first)), ("row_first", row_first), ("base", base)):
            pipeline.output(made[name], value)
        self.latency = pipeline.latency + 3

    def elaborate(self, platform):
        m = Module()
        self._pipeline.add_to(m)
        side = self._config.icu.tile_bits
        m.submodules.next = self._next
        begins, walked = self._next.o, Signal(self._window)
        walks = Signal()
        tile_row, tile_column = (Signal.like(walked.row_first[side:]) for _ in range(2))
        base, second = Signal.like(walked.base), Signal()
        first_of_piece, piece = Signal.like(walked.column_first), Signal.like(walked.columns)
        # Computed a step ahead, because they decide whether the next window is accepted: ``loads`` says that no window
        # is walked, or that its walk ends.
        last_column, last_row, ends, loads = Signal(), Signal(), Signal(), Signal(init=1)
        first_column = tile_column == first_of_piece[side:]

        def inside(at_first, first, at_last, last):
            """Of the columns or rows of a tile those that lie in the window."""
            return Cat((~at_first | (k >= first[:side])) & (~at_last | (k <= last[:side])) for k in range(1 << side))

        step, out, enable, ends_next = self.o.payload, self.o, Signal(), Signal()
        # A copy of ``walks & out.valid``: a LUT less in front of the enable of a window's many registers.
        steps, is_held = out.ready | ~out.valid, Signal()
        m.d.comb += [enable.eq(~is_held | out.ready), begins.ready.eq(loads & enable)]
        m.d.sync += is_held.eq(Mux(loads & enable, begins.valid, walks) & Mux(steps, walks, out.valid))
        with m.If(steps):
            columns = inside(first_column, first_of_piece, last_column, piece.last)
            rows = inside(tile_row == walked.row_first[side:], walked.row_first, last_row, walked.rows.last)
            m.d.sync += [
                out.valid.eq(walks), step.slot.eq(walked.slot), step.threshold.eq(walked.threshold),
                step.tile.eq(base + tile_column), step.tile_row.eq(tile_row), step.tile_column.eq(tile_column),
                step.columns.eq(columns), step.rows.eq(Mux(walked.some, rows, 0)), step.last.eq(ends)]
        with m.If(enable):
            m.d.sync += [ends.eq(ends_next), loads.eq(ends_next | (loads & ~begins.valid))]
            with m.If(loads):
                window = begins.payload
                m.d.comb += ends_next.eq(
                    ~window.some | (window.columns.single & window.rows.single & ~window.round))
                m.d.sync += [walks.eq(begins.valid), walked.eq(window), second.eq(0), base.eq(window.base),
                             tile_row.eq(window.row_first[side:]), tile_column.eq(window.column_first[side:]),
                             first_of_piece.eq(window.column_first), piece.eq(window.columns),
                             last_column.eq(window.columns.single), last_row.eq(window.rows.single)]
            with m.Elif(~last_column):
                m.d.comb += ends_next.eq(
                    ~walked.some | ((tile_column == piece.before) & last_row & (second | ~walked.round)))
                m.d.sync += [tile_column.eq(tile_column + 1), last_column.eq(tile_column == piece.before)]
            with m.Elif(walked.round & ~second):
                m.d.comb += ends_next.eq(~walked.some | (walked.wrapped.single & last_row))
                m.d.sync += [second.eq(1), tile_column.eq(0), first_of_piece.eq(0),
                             piece.eq(walked.wrapped), last_column.eq(walked.wrapped.single)]
            with m.Else():
                m.d.comb += ends_next.eq(~walked.some | (
                    walked.columns.single & (tile_row == walked.rows.before) & ~walked.round))
                m.d.sync += [second.eq(0), tile_column.eq(walked.column_first[side:]), tile_row.eq(tile_row + 1),
                             base.eq(base + self.tiles_across), first_of_piece.eq(walked.column_first),
                             piece.eq(walked.columns), last_column.eq(walked.columns.single),
                             last_row.eq(tile_row == walked.rows.before)]
        return m
