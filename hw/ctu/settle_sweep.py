"""Settle sweep: the smallest settle codes of all squares, read in the background."""

from amaranth.hdl import Cat, Const, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.ctu.square_scan import SIDE_BITS, square
from hw.formats import Formats
from hw.lib.checks import count_steps
from hw.lib.fixed import extreme, small_product
from hw.lib.pipeline import Pipeline
from hw.lib.queue import Queue
from hw.lib.skid_buffer import SkidBuffer

__all__ = ["SettleSweep"]

# Tiles in flight: requested, or outside the section.
TILES = 16


class SettleSweep(wiring.Component):
    """Reads the section's tiles again and again: of each the smallest code, and of each square that they make up.

    Rays beyond the section's border do not count. The tiles of a square of the highest level come one after the other,
    and within it those of each square below, so that one minimum for each level is enough.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i_start : In, stream without payload
        Begins a frustum; accepted when no tile is outstanding. The intersection unit has begun it before.
    section : In, `Formats.section`
        Constant until the next frustum begins.
    runs : In(1)
        Nothing is read while it is 0, so that the next frustum need not wait. Initially 1.
    o_tile : Out, stream of tiles; i_word : In, stream of settle words
        Reads of the settle map, and their words.
    o_<level> : Out, stream of `square`
        One stream for each level. Always ready.
    fresh : Out(1)
        All squares have been read in this frustum.

    Timing
    ------
    Latency: ``bits(side_bits - tile_bits) + 4 * tile_bits + 7`` cycles from a tile's read to its square. One tile per
    cycle, also if it lies beyond the border within a square of the highest level; stalls with the settle map.

    Golden counterpart: `golden.engine.ctu.settle_pyramid.SettlePyramid`.
    """

    def __init__(self, *, config: Config):
        self._config, self._formats = config, Formats(config)
        formats = self._formats
        self._levels = config.ctu.pyramid_levels
        super().__init__({
            "i_start": In(stream.Signature(0)), "section": In(formats.section), "runs": In(1, init=1),
            "o_tile": Out(stream.Signature(formats.tile)), "i_word": In(stream.Signature(formats.settle_word)),
            **{f"o_{level}": Out(stream.Signature(square(config, level), always_ready=True))
               for level in range(self._levels)},
            "fresh": Out(1)})
        bits = config.icu.side_bits - config.icu.tile_bits
        # A tile: whether it is in the section, which of its columns and rows are, and the last one of a sweep.
        side = 1 << config.icu.tile_bits
        self._tile = StructLayout({"column": bits, "row": bits, "within": 1, "columns": side, "rows": side, "last": 1})
        self._across = Signal(formats.count)
        self._turn = stream.Signature(self._tile).create()
        self._skid = SkidBuffer(StructLayout({**self._tile.members, "tile": formats.tile}))
        self._turns = pipeline = Pipeline(self._turn, self._skid.i, ready_next=self._skid.ready_next)
        given, made = self._turn.payload, self._skid.i.payload
        row = pipeline.combine(lambda row: Cat(row, 0).as_signed(), pipeline.input(given.row))
        product = small_product(pipeline, row, pipeline.constant(Cat(self._across, 0).as_signed()))
        pipeline.output(made.tile, pipeline.register(
            lambda product, column: product + column, product, pipeline.input(given.column)))
        for name in self._tile.members:
            pipeline.output(made[name], pipeline.input(given[name]))

        # The smallest code of a tile.
        lanes = StructLayout({**self._tile.members, "word": formats.settle_word})
        self._come = stream.Signature(lanes, always_ready=True).create()
        self._made = stream.Signature(StructLayout({**self._tile.members, "code": formats.settle}),
                                      always_ready=True).create()
        self._codes = pipeline = Pipeline(self._come, self._made)
        come = self._come.payload
        counts = pipeline.register(lambda columns, rows, within: Cat(
            columns & (rows[k] & within).replicate(side) for k in range(side)), *(
                pipeline.input(come[name]) for name in ("columns", "rows", "within")))
        word = pipeline.input(come.word)
        codes = [pipeline.register(lambda counts, word, k=k: Mux(counts[k], word[k], config.icu.settle.high), counts,
                                   word) for k in range(side * side)]
        pipeline.output(self._made.payload.code, extreme(pipeline, codes, largest=False))
        for name in self._tile.members:
            pipeline.output(self._made.payload[name], pipeline.input(come[name]))

    def elaborate(self, platform):
        m = Module()
        icu, section, formats = self._config.icu, self.section, self._formats
        side_bits, bits = icu.tile_bits, icu.side_bits - icu.tile_bits
        inner_bits = SIDE_BITS * (self._levels - 1)
        # Of the section: the last tiles, their last lanes, and the last squares of the highest level.
        last, last_lane = {}, {}
        for axis, first, end in (("column", section.first_column, section.end_column),
                                ("row", section.first_row, section.end_row)):
            ray = Signal(formats.index, name=f"last_{axis}")
            m.d.sync += ray.eq(end - first - 1)
            last[axis], last_lane[axis] = ray[side_bits:], ray[:side_bits]
        m.d.sync += self._across.eq(last["column"] + 1)

        # The next tile: counted within the squares of the highest level, and these by column and row.
        active, begins = Signal(), self.i_start.valid & self.i_start.ready
        inner = Signal(2 * inner_bits)
        outer = {axis: Signal(bits, name=f"outer_{axis}") for axis in last}
        outer_last = {axis: outer[axis] == last[axis] >> inner_bits for axis in last}
        position = {}
        for offset, axis in enumerate(last):
            digits = [inner[2 * SIDE_BITS * k + SIDE_BITS * offset:][:SIDE_BITS] for k in range(self._levels - 1)]
            position[axis] = Cat(*digits, outer[axis])[:bits]
        turn = self._turn
        shown = Signal(self._tile, reset_less=True)
        ends = inner.all() & outer_last["column"] & outer_last["row"] if inner_bits else \
            outer_last["column"] & outer_last["row"]
        m.d.comb += [turn.payload.eq(shown)]
        advances = Signal()
        m.d.comb += advances.eq(active & self.runs & ~self.i_start.valid & turn.ready)
        with m.If(turn.ready):
            m.d.sync += turn.valid.eq(advances)
            m.d.sync += [shown.last.eq(ends), shown.within.eq((position["column"] <= last["column"])
                                                              & (position["row"] <= last["row"]))]
            for axis, lanes in (("column", shown.columns), ("row", shown.rows)):
                m.d.sync += [shown[axis].eq(position[axis]), lanes.eq(Cat(
                    (position[axis] != last[axis]) | (k <= last_lane[axis]) for k in range(1 << side_bits)))]
        with m.If(advances):
            m.d.sync += inner.eq(inner + 1)
            with m.If(inner.all() if inner_bits else Const(1)):
                m.d.sync += outer["column"].eq(outer["column"] + 1)
                with m.If(outer_last["column"]):
                    m.d.sync += [outer["column"].eq(0), outer["row"].eq(Mux(outer_last["row"], 0, outer["row"] + 1))]
        self._turns.add_to(m)

        # Requests and replies.
        m.submodules.skid, request = self._skid, self._skid.o
        m.submodules.waiting = waiting = Queue(self._tile, depth=TILES)
        waits = waiting.o.payload
        requests = request.valid & waiting.i.ready & request.payload.within
        m.d.comb += [
            self.o_tile.valid.eq(requests), self.o_tile.payload.eq(request.payload.tile),
            request.ready.eq(waiting.i.ready & (self.o_tile.ready | ~request.payload.within)),
            waiting.i.valid.eq(request.valid & (self.o_tile.ready | ~request.payload.within)),
            *(waiting.i.payload[name].eq(request.payload[name]) for name in self._tile.members),
            self._come.valid.eq(waiting.o.valid & (self.i_word.valid | ~waits.within)),
            waiting.o.ready.eq(self.i_word.valid | ~waits.within),
            self.i_word.ready.eq(waiting.o.valid & waits.within), self._come.payload.word.eq(self.i_word.payload),
            *(self._come.payload[name].eq(waits[name]) for name in self._tile.members)]
        self._codes.add_to(m)

        # The next frustum begins when nothing of the last one is in flight.
        in_flight = Signal(8)
        count_steps(m, in_flight, up=advances, down=self._made.valid, most=(1 << len(in_flight)) - 1)
        m.d.comb += self.i_start.ready.eq((in_flight == 0) & ~turn.valid)
        with m.If(begins):
            m.d.sync += [active.eq(1), inner.eq(0), *(count.eq(0) for count in outer.values())]

        # Squares of all levels; a code is written two cycles after it comes.
        made, code = self._made.payload, self._made.payload.code
        within_square = Cat(*(part for k in range(self._levels - 1)
                              for part in (made.column[SIDE_BITS * k:][:SIDE_BITS],
                                           made.row[SIDE_BITS * k:][:SIDE_BITS])))
        for level in range(self._levels):
            output, within = getattr(self, f"o_{level}"), within_square[:2 * SIDE_BITS * level]
            smallest = code
            if level:
                so_far = Signal(formats.settle, name=f"so_far_{level}", reset_less=True)
                smallest = Mux(within.any() & (so_far < code), so_far, code)
                with m.If(self._made.valid):
                    m.d.sync += so_far.eq(smallest)
            m.d.comb += [output.valid.eq(self._made.valid & (within.all() if level else made.within)),
                         output.payload.code.eq(smallest),
                         output.payload.column.eq(made.column >> SIDE_BITS * level),
                         output.payload.row.eq(made.row >> SIDE_BITS * level)]
        written = Signal(3)
        m.d.sync += written.eq((written << 1) | (self._made.valid & made.last))
        with m.If(written[-1]):
            m.d.sync += self.fresh.eq(1)
        with m.If(begins):
            m.d.sync += [self.fresh.eq(0), written.eq(0)]
        return m
