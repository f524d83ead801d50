"""IC ray generator: from windows to the rays that may still improve."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import IcuFormats
from hw.icu.ray_issue import RayIssue
from hw.icu.window_walk import WindowWalk
from hw.lib.checks import claim, claim_steps, count_entries
from hw.lib.queue import Queue

__all__ = ["IcRayGenerator"]

# Masks between the walk and the issue, including those that wait for their settle word. It is a power of two: the
# highest bit of the number of masks is 1 when no entry is free.
MASKS = 16


class IcRayGenerator(wiring.Component):
    """Lazy isolation, a tile at a time: rays whose settle code is below the patch's threshold are issued.

    The walk visits one tile per cycle while the rays that it found are issued, one per cycle. Masks without rays are
    discarded, except for a window's last one, with which the patch retires.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `IcuFormats.patch_window`
        Windows of patches.
    o_walk : Out, stream of ``tag``, ``tile``, always ready
        To `SettleMap.i_walk`; the tag is the `IcuFormats.tile_step`.
    i_walk : In, stream of ``tag``, ``word``, always ready
        From `SettleMap.o_walk`.
    o : Out, stream of `IcuFormats.issued`, always ready
        Rays.
    section : In, `Formats.section`
        Of the frustum; stable while windows are in flight.
    tiles_across : In, `Formats.count`
        Of the frustum; stable while windows are in flight.
    visited : Out(range(rays of a tile + 1))
        Rays of windows whose settle code was tested in this cycle.

    Timing
    ------
    A window of n rays that may improve in w tiles takes max(n, w) cycles, and one more where its last tile has none of
    them and others have. Stalls nothing behind it.

    Golden counterpart: `golden.engine.icu.window_walk`. Source: Shen 1993, Fig. 5.12.
    """

    def __init__(self, *, config: Config):
        self._config, self._formats = config, IcuFormats(config)
        formats = self._formats
        step = formats.tile_step
        super().__init__({
            "i": In(stream.Signature(formats.patch_window)),
            "o_walk": Out(stream.Signature(StructLayout({"tag": step, "tile": formats.tile}), always_ready=True)),
            "i_walk": In(stream.Signature(StructLayout({"tag": step, "word": formats.settle_word}),
                                          always_ready=True)),
            "o": Out(stream.Signature(formats.issued, always_ready=True)),
            "section": In(formats.section), "tiles_across": In(formats.count),
            "visited": Out(range((1 << 2 * config.icu.tile_bits) + 1))})

    def elaborate(self, platform):
        m = Module()
        lanes = 1 << 2 * self._config.icu.tile_bits
        m.submodules.walk = walk = WindowWalk(config=self._config)
        m.submodules.masks = masks = Queue(self._formats.tile_rays, depth=MASKS)
        m.submodules.issue = issue = RayIssue(config=self._config)
        wiring.connect(m, wiring.flipped(self.i), walk.i)
        wiring.connect(m, masks.o, issue.i)
        wiring.connect(m, issue.o, wiring.flipped(self.o))

        window, section = self.i.payload.window, self.section
        has_rays = self.i.valid & window.row_count.any() & window.column_count.any()
        claim(m, ~has_rays | ((window.column_first + window.column_count <= section.end_column - section.first_column)
                              & (window.wrapped_count <= window.column_first)
                              & (window.row_first + window.row_count <= section.end_row - section.first_row)),
              "a window lies within the section")

        # Entries of the queue that are used or reserved.
        taken, drops = Signal(range(MASKS + 1)), Signal()
        steps = walk.o.valid & ~taken[-1]
        m.d.comb += [walk.tiles_across.eq(self.tiles_across), issue.first_column.eq(self.section.first_column),
                     issue.first_row.eq(self.section.first_row), walk.o.ready.eq(~taken[-1]),
                     self.o_walk.valid.eq(steps), self.o_walk.payload.tile.eq(walk.o.payload.tile),
                     self.o_walk.payload.tag.eq(walk.o.payload)]
        # Whether a mask leaves is known late.
        count_entries(taken)
        claim_steps(m, taken, up=steps, down=drops + (masks.o.valid & masks.o.ready), most=MASKS)
        claim(m, ~masks.i.valid | masks.i.ready, "a mask has an entry")
        remain = (taken + steps - drops)[:len(taken)]
        m.d.sync += taken.eq(Mux(masks.o.valid & masks.o.ready, remain - 1, remain))

        # Which rays lie in the window, and which of them may improve.
        step, word = self.i_walk.payload.tag, self.i_walk.payload.word
        inside = Cat(column & row for row in step.rows for column in step.columns)
        found, valid, visits = Signal(self._formats.tile_rays), Signal(), Signal(lanes)
        m.d.sync += [
            valid.eq(self.i_walk.valid), visits.eq(inside & self.i_walk.valid.replicate(lanes)),
            found.slot.eq(step.slot), found.last.eq(step.last), found.tile.eq(step.tile),
            found.tile_column.eq(step.tile_column), found.tile_row.eq(step.tile_row),
            found.mask.eq(inside & Cat(word[lane] < step.threshold for lane in range(lanes)))]
        some = found.mask.any() | found.last
        m.d.comb += [drops.eq(valid & ~some), masks.i.valid.eq(valid & some), masks.i.payload.eq(found)]
        count = Signal.like(self.visited)
        m.d.comb += count.eq(sum(visits[lane] for lane in range(lanes)))
        m.d.sync += self.visited.eq(count)
        return m
