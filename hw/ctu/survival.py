"""Survival: which grid rays go on."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout, View
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.ctu.ctu_formats import CtuFormats
from hw.ctu.group_split import GROUPS as SPLIT_GROUPS
from hw.ctu.group_split import GroupSplit
from hw.ctu.near_window import NearWindow
from hw.ctu.settle_sweep import SettleSweep
from hw.ctu.square_scan import SquareScan, extent
from hw.icu.section_clip import SectionClip
from hw.lib.checks import claim_steps
from hw.lib.credit_gate import CreditGate
from hw.lib.pipeline import Pipeline
from hw.lib.queue import Queue

__all__ = ["Survival"]

# Windows between a gate and the first scan: more than the cycles that they take.
CREDITS = 20
# Groups in front of each further scan.
QUEUED = 4
# Rays that are not looked up together: hardly anything would be saved.
FEW = 2


class Survival(wiring.Component):
    """A grid ray survives while a square with near rays is live.

    ::

        i -+-----------+- NearWindow - SectionClip -+- groups - SquareScan of the highest level - ... -+- SquareScan
           |           |                            '- rays alone --------------------------------------'  of the tiles
           '- GroupSplit - live groups -------------------------------------------------------------------'   '- o
        SettleSweep - codes of all squares

    Neighbours in a row stand for nearly the same rays, so they are looked up together first: a group that a level finds
    dead ends here, and of one that all levels find live each ray is looked up among the tiles, as is one of few.
    The squares' codes are what the sweep has found: old ones say "live" too often, and no ray waits for new ones.

    Parameters
    ----------
    config
        The configuration.
    ray
        Shape of a grid ray: a structure with ``shell``, ``row`` and ``column``, addresses in the tables, ``ray``, its
        number, and a sideband.

    Members
    -------
    i_start : In, stream without payload
        See `SettleSweep`; the sender guarantees that no grid ray is in flight.
    i_table : In, stream of `CtuFormats.grid_table_write`
        Table entries. Always ready.
    i : In, stream of ``first``, ``count``
        A group: its first grid ray, and how many neighbours there are, at least one.
    o : Out, stream of the grid ray's shape
        A grid ray that survives.
    o_dropped_<level> : Out, stream of ``first``, ``count``
        One stream for each level: grid rays that do not. Always ready.
    o_tile : Out, stream of tiles; i_word : In, stream of settle words
        Reads of the settle map, and their words.
    frustum : In, `Formats.frustum`
        Constant until the next one begins.
    runs : In(1)
        See `SettleSweep`.

    Timing
    ------
    Latency: ``26`` cycles for a grid ray alone that a single word is looked up for. A word of 4 x 4 squares of each
    level per cycle; in each cycle a group or a ray of a live group enters. Stalls with ``o``.

    Golden counterpart: `golden.engine.ctu.survival.survivors_by_code`. Source: docs/exactness.md.
    """

    def __init__(self, *, config: Config, ray: StructLayout):
        self._config, self._formats = config, CtuFormats(config)
        formats = self._formats
        self._levels = config.ctu.pyramid_levels
        self._group = StructLayout({"first": ray, "count": formats.grid_group})
        # What a window is of: a group, or a ray alone that is looked up among the tiles.
        self._tag = StructLayout({**self._group.members, "alone": 1})
        self._item = StructLayout({"tag": self._tag, "threshold": formats.threshold})
        self._near = NearWindow(config=config, tag=self._tag)
        self._clip = SectionClip(config=config, slot=self._item)
        super().__init__({
            "i_start": In(stream.Signature(0)), "i_table": In(self._near.i_table.signature.flip()),
            "i": In(stream.Signature(self._group)), "o": Out(stream.Signature(ray)),
            **{f"o_dropped_{level}": Out(stream.Signature(self._group, always_ready=True))
               for level in range(self._levels)},
            "o_tile": Out(stream.Signature(formats.tile)), "i_word": In(stream.Signature(formats.settle_word)),
            "frustum": In(formats.frustum), "runs": In(1, init=1)})
        self._request = StructLayout({**self._item.members, "extent": extent(config)})
        self._scans = [SquareScan(config=config, level=level, tag=self._tag) for level in range(self._levels)]
        self._split, self._queue = GroupSplit(ray), Queue(self._request, depth=CREDITS)
        # The last ones of a window, from the first ones and how many there are.
        self._extents = stream.Signature(self._request, always_ready=True).create()
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
        # A register in front of the near windows.
        self.latency = 1 + sum(block.latency for block in (
            self._split, self._near, self._clip, pipeline, self._queue, self._scans[0]))

    def elaborate(self, platform):
        m = Module()
        m.submodules.near, m.submodules.clip, m.submodules.split = near, clip, split = (
            self._near, self._clip, self._split)
        m.submodules.sweep = sweep = SettleSweep(config=self._config)
        section = self.frustum.section
        wiring.connect(m, wiring.flipped(self.i_table), near.i_table)
        wiring.connect(m, wiring.flipped(self.i_start), sweep.i_start)
        wiring.connect(m, sweep.o_tile, wiring.flipped(self.o_tile))
        wiring.connect(m, wiring.flipped(self.i_word), sweep.i_word)
        self._ends.add_to(m)
        given, made = near.o.payload, self._extents.payload
        m.d.comb += [
            near.is_screen.eq(self.frustum.is_screen), near.columns.eq(self.frustum.columns),
            clip.i.valid.eq(near.o.valid), clip.i.payload.window.eq(given.window),
            clip.i.payload.slot.tag.eq(given.tag), clip.i.payload.slot.threshold.eq(given.threshold),
            clip.frustum.eq(self.frustum), sweep.section.eq(section), sweep.runs.eq(self.runs)]
        columns = Signal(self._formats.count)
        m.d.sync += columns.eq(section.end_column - section.first_column)

        alone, groups, group_gate = self._add_near_windows(m)
        for queue, is_mine in ((alone, made.tag.alone), (groups, ~made.tag.alone)):
            m.d.comb += [queue.i.valid.eq(self._extents.valid & is_mine), queue.i.payload.eq(made)]
        source = groups.o
        for level in reversed(range(self._levels)):
            m.submodules[f"scan_{level}"] = scan = self._scans[level]
            dropped, squares = getattr(self, f"o_dropped_{level}"), getattr(sweep, f"o_{level}")
            m.d.comb += [
                scan.columns.eq(columns), scan.fresh.eq(sweep.fresh), scan.i_square.valid.eq(squares.valid),
                scan.i_square.payload.eq(squares.payload)]
            found = scan.o.payload
            m.d.comb += [dropped.valid.eq(scan.o.valid & ~found.live), dropped.payload.first.eq(found.tag.first),
                         dropped.payload["count"].eq(found.tag["count"])]
            if level:
                m.submodules[f"queue_{level}"] = following = Queue(self._request, depth=QUEUED)
                m.d.comb += [
                    scan.i.valid.eq(source.valid), source.ready.eq(scan.i.ready),
                    *(scan.i.payload[name].eq(source.payload[name]) for name in self._request.members),
                    *(following.i.payload[name].eq(found[name]) for name in self._request.members),
                    following.i.valid.eq(scan.o.valid & found.live), scan.o.ready.eq(following.i.ready | ~found.live)]
                source = following.o

        # Groups go before rays alone, here and to the near windows: there are so few that rays are hardly late, and
        # the next ones are known when those of the last group have gone. A live group never waits: it has a
        # reserved entry in the split, since its rays pass here too. Few rays, of which looking together
        # saves nothing, go there at once.
        split, given, lives, reserved = self._split, scan.i, scan.o.valid & found.live, Signal(range(SPLIT_GROUPS + 1))
        # An offer that the scan has not accepted stays, be it a group or a ray alone.
        held, held_group, groups_may = Signal(), Signal(), Signal()
        enters = source.valid & groups_may
        m.d.comb += groups_may.eq(Mux(held, held_group, reserved != SPLIT_GROUPS))
        m.d.sync += [held.eq(given.valid & ~given.ready), held_group.eq(enters)]
        view = View(self._request, Mux(enters, source.payload.as_value(), alone.o.payload.as_value()))
        dies = scan.o.valid & scan.o.ready & ~found.live & ~found.tag.alone
        few, comes, admits = self.i.payload["count"] <= FEW, lives & ~found.tag.alone, Signal()
        m.d.comb += [admits.eq((reserved < SPLIT_GROUPS - 1) & ~comes),
                     group_gate.i.valid.eq(self.i.valid & ~few), group_gate.i.payload.eq(self.i.payload),
                     self.i.ready.eq(Mux(few, admits, group_gate.i.ready))]
        claim_steps(m, reserved, up=(source.valid & source.ready) + (self.i.valid & few & admits),
                    down=dies + split.leaves, most=SPLIT_GROUPS)
        m.d.sync += reserved.eq(
            reserved + (source.valid & source.ready) + (self.i.valid & few & admits) - dies - split.leaves)
        m.d.comb += [
            given.valid.eq(alone.o.valid | enters), alone.o.ready.eq(given.ready & ~enters),
            source.ready.eq(given.ready & groups_may),
            *(given.payload[name].eq(view[name]) for name in self._request.members),
            self.o.valid.eq(lives & found.tag.alone), self.o.payload.eq(found.tag.first),
            split.i.valid.eq(comes | (self.i.valid & few & admits)),
            split.i.payload.first.eq(Mux(comes, found.tag.first.as_value(), self.i.payload.first.as_value())),
            split.i.payload["count"].eq(Mux(comes, found.tag["count"], self.i.payload["count"])),
            scan.o.ready.eq(self.o.ready | ~lives | ~found.tag.alone)]
        return m

    def _add_near_windows(self, m):
        """Arbitration for the near windows, and queues for the windows of rays alone and of groups."""
        m.submodules.alone, m.submodules.gate = alone, gate = (
            self._queue, CreditGate(self._split.o.payload.shape(), credits=CREDITS))
        m.d.comb += gate.i_return.valid.eq(alone.o.valid & alone.o.ready)
        wiring.connect(m, self._split.o, gate.i)
        starts, item = Signal(), Signal(self._near.i.payload.shape(), reset_less=True)
        near, ray = self._near.i, gate.o.payload
        m.submodules.groups = groups = Queue(self._request, depth=CREDITS)
        m.submodules.group_gate = group_gate = CreditGate(self._group, credits=CREDITS)
        group, first = group_gate.o.payload, group_gate.o.payload.first
        m.d.comb += [
            near.valid.eq(starts), near.payload.eq(item),
            gate.o.ready.eq(~group_gate.o.valid), group_gate.o.ready.eq(1),
            group_gate.i_return.valid.eq(groups.o.valid & groups.o.ready)]
        m.d.sync += [starts.eq(gate.o.valid | group_gate.o.valid), item.tag.alone.eq(~group_gate.o.valid)]
        with m.If(~group_gate.o.valid):
            m.d.sync += [item.tag.first.eq(ray), item.tag["count"].eq(1), item.last.eq(ray.column),
                         *(item[name].eq(ray[name]) for name in ("shell", "row", "column"))]
        with m.Else():
            m.d.sync += [item.tag.first.eq(first), item.tag["count"].eq(group["count"]),
                         item.last.eq(first.column + group["count"] - 1),
                         *(item[name].eq(first[name]) for name in ("shell", "row", "column"))]
        return alone, groups, group_gate
