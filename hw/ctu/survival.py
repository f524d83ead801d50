"""Survival: which grid rays go on."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.ctu.near_window import NearWindow
from hw.ctu.settle_sweep import SettleSweep
from hw.ctu.square_scan import SquareScan, extent
from hw.formats import Formats
from hw.icu.section_clip import SectionClip
from hw.lib.credit_gate import CreditGate
from hw.lib.pipeline import Pipeline
from hw.lib.queue import Queue

__all__ = ["Survival"]

# Grid rays between the gate and the first scan: more than the cycles that they take.
CREDITS = 20
# Grid rays in front of each further scan.
ROOM = 4


class Survival(wiring.Component):
    """A grid ray goes on while a square with rays near it is live.

    ::

        i - NearWindow - SectionClip - SquareScan of the highest level - ... - SquareScan of the tiles - o
                                            '- SettleSweep -------------------------'

    A grid ray that a level finds dead goes no further. The squares' codes are what the sweep has found: old ones say
    "live" too often, and nobody waits for new ones.

    Parameters
    ----------
    config
        The configuration.
    tag
        Shape of what goes along.

    Members
    -------
    i_start
        See `SettleSweep`; the sender sees to it that no grid ray is under way. No payload.
    i_table
        `Formats.grid_table_write`. Always ready.
    i
        ``tag``, ``shell``, ``row`` and ``column``, places in the tables.
    o
        ``tag`` of a grid ray that goes on.
    o_dropped
        An array of streams, one for each level: ``tag`` of a grid ray that does not. Always ready.
    o_tile, i_word
        The settle map's ``i_read`` and ``o_read``.
    lowest
        See `SettleSweep`.
    frustum
        `Formats.frustum`, the same until the next one begins.

    Timing
    ------
    Latency: ``7 * pyramid_levels + 14`` cycles for a grid ray that a single word of each level is looked up for. A word
    of 4 x 4 squares of each level per cycle, and a grid ray per cycle at most; stalls with ``o``.

    Golden counterpart: `golden.ctu.survival.survivors_by_code`. Source: design.md section 5.
    """

    def __init__(self, *, config: Config, tag):
        self._config, self._formats, self._tag = config, Formats(config), tag
        formats = self._formats
        self._levels = config.ctu.pyramid_levels
        self._item = StructLayout({"tag": tag, "threshold": formats.threshold})
        self._near = NearWindow(config=config, tag=tag)
        self._clip = SectionClip(config=config, slot=self._item)
        super().__init__({
            "i_start": In(stream.Signature(0)), "i_table": In(self._near.i_table.signature.flip()),
            "i": In(stream.Signature(self._near.i.payload.shape())), "o": Out(stream.Signature(tag)),
            **{f"o_dropped_{level}": Out(stream.Signature(tag, always_ready=True)) for level in range(self._levels)},
            "o_tile": Out(stream.Signature(formats.tile)), "i_word": In(stream.Signature(formats.settle_word)),
            "lowest": Out(formats.settle), "frustum": In(formats.frustum)})
        asked = StructLayout({**self._item.members, "extent": extent(config)})
        self._scans = [SquareScan(config=config, level=level, tag=tag) for level in range(self._levels)]
        self._queue = Queue(asked, depth=CREDITS)
        # The last ones of a window, from the first ones and how many there are.
        self._extents = stream.Signature(asked, always_ready=True).create()
        self._ends = pipeline = Pipeline(self._clip.o, self._extents)
        given, made = self._clip.o.payload, self._extents.payload
        window = given.window

        def last(first, count):
            return pipeline.register(lambda first, count: (first + count - 1)[:config.icu.side_bits],
                                     pipeline.input(first), pipeline.input(count))

        for target, value in (
                (made.tag, pipeline.input(given.slot.tag)), (made.threshold, pipeline.input(given.slot.threshold)),
                (made.extent.some, pipeline.register(lambda rows, columns: rows.any() & columns.any(), pipeline.input(
                    window.row_count), pipeline.input(window.column_count))),
                (made.extent.round, pipeline.input(window.wrapped_count.any())),
                (made.extent.column_first, pipeline.input(window.column_first)),
                (made.extent.column_last, last(window.column_first, window.column_count)),
                (made.extent.wrapped_last, last(0, window.wrapped_count)),
                (made.extent.row_first, pipeline.input(window.row_first)),
                (made.extent.row_last, last(window.row_first, window.row_count))):
            pipeline.output(target, value)
        self._ahead = self._near.latency + self._clip.latency + pipeline.latency
        self.latency = self._ahead + self._queue.latency + sum(scan.latency for scan in self._scans) + self._levels - 1

    def elaborate(self, platform):
        m = Module()
        m.submodules.near, m.submodules.clip, m.submodules.queue = near, clip, queue = (
            self._near, self._clip, self._queue)
        m.submodules.gate = gate = CreditGate(self.i.payload.shape(), credits=CREDITS)
        m.submodules.sweep = sweep = SettleSweep(config=self._config)
        section = self.frustum.section
        wiring.connect(m, wiring.flipped(self.i), gate.i)
        wiring.connect(m, wiring.flipped(self.i_table), near.i_table)
        wiring.connect(m, wiring.flipped(self.i_start), sweep.i_start)
        wiring.connect(m, sweep.o_tile, wiring.flipped(self.o_tile))
        wiring.connect(m, wiring.flipped(self.i_word), sweep.i_word)
        self._ends.add_to(m)
        given = near.o.payload
        m.d.comb += [
            near.i.valid.eq(gate.o.valid), gate.o.ready.eq(1), near.i.payload.eq(gate.o.payload),
            near.is_screen.eq(self.frustum.is_screen), near.columns.eq(self.frustum.columns),
            clip.i.valid.eq(near.o.valid), clip.i.payload.window.eq(given.window),
            clip.i.payload.slot.tag.eq(given.tag), clip.i.payload.slot.threshold.eq(given.threshold),
            clip.frustum.eq(self.frustum), queue.i.valid.eq(self._extents.valid),
            queue.i.payload.eq(self._extents.payload), gate.i_return.valid.eq(queue.o.valid & queue.o.ready),
            sweep.section.eq(section), self.lowest.eq(sweep.lowest)]
        columns = Signal(self._formats.count)
        m.d.sync += columns.eq(section.end_column - section.first_column)

        source = queue.o
        for level in reversed(range(self._levels)):
            m.submodules[f"scan_{level}"] = scan = self._scans[level]
            dropped, squares = getattr(self, f"o_dropped_{level}"), getattr(sweep, f"o_{level}")
            m.d.comb += [
                scan.i.valid.eq(source.valid), source.ready.eq(scan.i.ready), scan.columns.eq(columns),
                *(scan.i.payload[name].eq(source.payload[name]) for name in ("tag", "threshold", "extent")),
                scan.fresh.eq(sweep.fresh), scan.i_square.valid.eq(squares.valid),
                scan.i_square.payload.eq(squares.payload)]
            found = scan.o.payload
            if level:
                m.submodules[f"queue_{level}"] = following = Queue(queue.o.payload.shape(), depth=ROOM)
                target = following.i
                m.d.comb += [target.payload[name].eq(found[name]) for name in ("tag", "threshold", "extent")]
                source = following.o
            else:
                target = self.o
                m.d.comb += target.payload.eq(found.tag)
            m.d.comb += [
                target.valid.eq(scan.o.valid & found.live), scan.o.ready.eq(target.ready | ~found.live),
                dropped.valid.eq(scan.o.valid & ~found.live), dropped.payload.eq(found.tag)]
        return m
