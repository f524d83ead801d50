"""Ray traversal: from requests for grid rays to cells."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.ctu.cell_traversal import CellTraversal
from hw.ctu.ctu_formats import CtuFormats
from hw.ctu.grid_direction import GridDirection
from hw.ctu.grid_entries import GridEntries
from hw.ctu.ray_banks import RayBanks
from hw.ctu.stage_count import FIRST, StageCount, stage_index_bits
from hw.ctu.survival import Survival
from hw.lib.skid_buffer import SkidBuffer

__all__ = ["COUNTERS", "RayTraversal"]

COUNTERS = ("cycles", "requests", "rays", "steps", "cells", "deferrals", "overlaps", "waits_for_survival",
            "waits_for_rays", "waits_for_traversal", "waits_for_cells")
COUNTER_BITS = 32


class RayTraversal(wiring.Component):
    """The back end of cell traversal.

    ::

        i - Survival - RayBanks - GridEntries - GridDirection - CellTraversal -+- o
                          '--------------------- last of a ray ---------------'
        i_near -----------------------------------------------------------------'

    A frustum: write its tables, give its numbers, send the near cells and the requests. It is over with the final item.

    Parameters
    ----------
    config
        The configuration.
    pipelines
        See `CellTraversal`.

    Members
    -------
    i_frustum
        `CtuFormats.traversal_frustum`. Taken when the last one is over. The intersection unit has begun the frustum
        before.
    i_table
        `CtuFormats.grid_table_write`. Always ready; not while a frustum is under way.
    i_near
        `CtuFormats.near_cell`, the cells of shell 1, first of all.
    i
        `CtuFormats.grid_request`, taken behind the near cells; with a lead of 0 when they are over.
    o_over
        A stage of requests is over: no payload. Always ready.
    o
        `CtuFormats.met_cell`. The near cells' stage is the one before the first requests'.
    settled
        See `StageCount`.
    o_tile, i_word
        The settle map's ``i_read`` and ``o_read``.
    lowest
        See `SettleSweep`.
    counters
        Since the frustum began: cycles until it was over, grid rays looked at, grid rays sent, steps, cells, requests
        that waited for a ray under way; cycles in which rays of several subshells were under way, in which a request
        waited for survival, a surviving ray for the ray memory, a ray that left for traversal, and a cell to be taken.

    Timing
    ------
    Latency: ``5 * product_registers + 72`` cycles from a request for a ray alone to its first
    cell, with several pipelines one more. A request for neighbours, one ray and one cell per cycle;
    stalls with ``o``. After reset, and every 2^``generation_bits`` - 1 frusta, a frustum begins ``ray_slots`` cycles
    later.

    Golden counterpart: `golden.ctu.unit.CellTraversalUnit.open`. Source: Shen 1993, section 5.3.4.
    """

    def __init__(self, *, config: Config, pipelines: int = 1):
        self._config, self._formats = config, CtuFormats(config)
        formats, ctu = self._formats, config.ctu
        place = {"shell": formats.shell, "row": formats.grid_row_place, "column": formats.grid_column_place}
        self._ray = StructLayout({"stage": formats.stage, "ray": formats.grid_number, **place})
        self._memory = RayBanks(
            slots=ctu.ray_slots, version_bits=formats.grid_number.width - self._slot_bits + 1, deferred=ctu.deferred,
            generation_bits=config.icu.generation_bits, tag=StructLayout({"stage": formats.stage, **place}))
        sent = StructLayout({"stage": formats.stage, "slot": self._slot_bits})
        way = StructLayout({"sent": sent, "begin": formats.begin, "length": formats.parameter})
        self._survival = Survival(config=config, ray=self._ray)
        self._leaving = SkidBuffer(self._memory.o.payload.shape())
        self._entries, self._direction = GridEntries(config=config, tag=sent), GridDirection(config=config, tag=way)
        self._traversal = CellTraversal(config=config, tag=sent, pipelines=pipelines)
        # What stalls one of the three does not stall the others in the same cycle.
        self._found, self._turned = (SkidBuffer(block.o.payload.shape()) for block in (self._entries, self._direction))
        super().__init__({
            "i_frustum": In(stream.Signature(formats.traversal_frustum)),
            "i_table": In(self._survival.i_table.signature.flip()),
            "i_near": In(stream.Signature(formats.near_cell)), "i": In(stream.Signature(formats.grid_request)),
            "o_over": Out(stream.Signature(0, always_ready=True)), "o": Out(stream.Signature(formats.met_cell)),
            "settled": In(1 << stage_index_bits(config)), "o_tile": Out(stream.Signature(formats.tile)),
            "i_word": In(stream.Signature(formats.settle_word)), "lowest": Out(formats.settle),
            "counters": Out(StructLayout(dict.fromkeys(COUNTERS, COUNTER_BITS)))})
        self.latency = sum(block.latency for block in (
            self._survival, self._memory, self._leaving, self._entries, self._found, self._direction, self._turned,
            self._traversal))

    @property
    def _slot_bits(self):
        return self._config.ctu.ray_slots.bit_length() - 1

    def elaborate(self, platform):
        m = Module()
        config, levels = self._config, self._config.ctu.pyramid_levels
        m.submodules.survival, m.submodules.memory, m.submodules.entries = survival, memory, entries = (
            self._survival, self._memory, self._entries)
        m.submodules.direction, m.submodules.traversal = direction, traversal = self._direction, self._traversal
        m.submodules.stages = stages = StageCount(config=config, leaves=levels + len(memory.o_passed) + 1)

        # A frustum begins when both memories have.
        frustum, known, runs, accepts = Signal(self._formats.traversal_frustum), Signal(), Signal(), Signal()
        memory_begun, survival_begun = Signal(), Signal()
        given = self.i_frustum
        m.d.comb += [memory.i_start.valid.eq(known & ~memory_begun), survival.i_start.valid.eq(known & ~survival_begun),
                     given.ready.eq(accepts), stages.begins.eq(accepts)]
        m.d.sync += accepts.eq(known & memory_begun & survival_begun & ~accepts)
        with m.If(given.valid & ~runs & ~known):
            m.d.sync += [frustum.eq(given.payload), known.eq(1)]
        for block, begun in ((memory, memory_begun), (survival, survival_begun)):
            with m.If(block.i_start.valid & block.i_start.ready):
                m.d.sync += begun.eq(1)
        with m.If(accepts):
            m.d.sync += [known.eq(0), memory_begun.eq(0), survival_begun.eq(0), runs.eq(1)]
        m.d.comb += survival.frustum.eq(frustum.frustum)
        # With a cycle for the way: the first ray is not there before.
        m.d.sync += [direction.is_screen.eq(frustum.frustum.is_screen), direction.to_global.eq(frustum.to_global),
                     traversal.origin.eq(frustum.place), traversal.shape.eq(frustum.cells)]
        for block in survival, entries:
            m.d.comb += [block.i_table.valid.eq(self.i_table.valid), block.i_table.payload.eq(self.i_table.payload)]
        wiring.connect(m, survival.o_tile, wiring.flipped(self.o_tile))
        wiring.connect(m, wiring.flipped(self.i_word), survival.i_word)
        m.d.comb += self.lowest.eq(survival.lowest)

        # Requests: the near cells first; what is no ray only closes its stage.
        near_closed, all_closed, open_ = Signal(), Signal(), Signal()
        request, rays = self.i.payload, survival.i.payload
        takes, some = self.i.valid & self.i.ready, request["count"].any()
        m.d.comb += [
            open_.eq(runs & near_closed & ~all_closed & (stages.near_over if config.ctu.run_ahead == 0 else 1)),
            survival.i.valid.eq(self.i.valid & open_ & some), self.i.ready.eq(open_ & (survival.i.ready | ~some)),
            *(rays.first[name].eq(request[name]) for name in self._ray.members), rays["count"].eq(request["count"]),
            stages.enters.valid.eq(takes & some), stages.enters.payload["count"].eq(request["count"]),
            stages.enters.payload.stage.eq(request.stage)]
        near_closes = self.i_near.valid & self.i_near.ready & self.i_near.payload.last
        m.d.comb += [stages.closes.eq(near_closes | (takes & request.last)), stages.closed_all.eq(all_closed)]
        with m.If(near_closes):
            m.d.sync += near_closed.eq(1)
        with m.If(takes & request.final):
            m.d.sync += all_closed.eq(1)
        with m.If(accepts):
            m.d.sync += [near_closed.eq(0), all_closed.eq(0)]

        # Rays.
        m.submodules.leaving = leaving = self._leaving
        wiring.connect(m, memory.o, leaving.i)
        lives, leaves, bits = survival.o, leaving.o, self._slot_bits
        m.d.comb += [
            memory.i.valid.eq(lives.valid), lives.ready.eq(memory.i.ready),
            memory.i.payload.slot.eq(lives.payload.ray[:bits]),
            # Version 0 is of a slot that no ray has left.
            memory.i.payload.version.eq((lives.payload.ray >> bits) + 1),
            *(memory.i.payload.tag[name].eq(lives.payload[name]) for name in memory.i.payload.tag.shape().members),
            entries.i.valid.eq(leaves.valid), leaves.ready.eq(entries.i.ready),
            entries.i.payload.tag.slot.eq(leaves.payload.slot),
            entries.i.payload.tag.stage.eq(leaves.payload.tag.stage),
            *(entries.i.payload[name].eq(leaves.payload.tag[name]) for name in ("shell", "row", "column"))]
        m.submodules.found, m.submodules.turned = self._found, self._turned
        wiring.connect(m, entries.o, self._found.i)
        wiring.connect(m, direction.o, self._turned.i)
        found, turned = self._found.o, self._turned.o
        m.d.comb += [
            direction.i.valid.eq(found.valid), found.ready.eq(direction.i.ready),
            *(direction.i.payload[name].eq(found.payload[name]) for name in ("row", "column")),
            direction.i.payload.tag.sent.eq(found.payload.tag),
            *(direction.i.payload.tag[name].eq(found.payload[name]) for name in ("begin", "length")),
            traversal.i.valid.eq(turned.valid), turned.ready.eq(traversal.i.ready),
            traversal.i.payload.tag.eq(turned.payload.tag.sent),
            traversal.i.payload.direction.eq(turned.payload.direction),
            *(traversal.i.payload[name].eq(turned.payload.tag[name]) for name in ("begin", "length"))]

        # Cells; a ray's last item brings its ray back.
        met, near, out = traversal.o, self.i_near, self.o.payload
        ends, passes, sent = Signal(), near.valid & near.payload.is_cell, Signal()
        finishes = runs & stages.done & ~met.valid
        m.d.comb += [
            near.ready.eq(runs & ~near_closed & (self.o.ready | ~near.payload.is_cell)),
            met.ready.eq(near_closed & (self.o.ready | ~met.payload.is_cell)),
            self.o.valid.eq(Mux(near_closed, (met.valid & met.payload.is_cell) | finishes, runs & passes)),
            out.cell.eq(Mux(near_closed, met.payload.cell, near.payload.cell)),
            out.stage.eq(Mux(near_closed, met.payload.tag.stage, FIRST)), out.final.eq(near_closed & ~met.valid),
            ends.eq(met.valid & met.ready & met.payload.last), sent.eq(self.o.valid & self.o.ready)]
        m.d.sync += [memory.i_return.valid.eq(ends), memory.i_return.payload.eq(met.payload.tag.slot)]
        with m.If(sent & out.final):
            m.d.sync += runs.eq(0)
        dropped = [getattr(survival, f"o_dropped_{level}") for level in range(levels)]
        for place, (valid, stage, count) in enumerate((
                *((one.valid, one.payload.first.stage, one.payload["count"]) for one in dropped),
                *((one.valid, one.payload.stage, 1) for one in memory.o_passed), (ends, met.payload.tag.stage, 1))):
            m.d.comb += [stages.left[place].valid.eq(valid), stages.left[place].payload.stage.eq(stage),
                         stages.left[place].payload["count"].eq(count)]
        m.d.comb += [stages.settled.eq(self.settled), self.o_over.valid.eq(stages.over & stages.near_over)]

        # Which subshell a stage is of: a new one, if its shell does not come behind that of the stage before it. There
        # are no more of them under way than stages.
        index_bits = stage_index_bits(config)
        before, shell, present = Signal(index_bits), Signal(request.shell.shape()), Signal(index_bits)
        subshells = [Signal(index_bits, name=f"subshell_{index}") for index in range(1 << index_bits)]
        m.d.comb += present.eq(before + (request.shell <= shell))
        with m.If(takes & some):
            for index, subshell in enumerate(subshells):
                with m.If(request.stage[:index_bits] == index):
                    m.d.sync += subshell.eq(present)
        with m.If(takes & request.last):
            m.d.sync += [before.eq(present), shell.eq(request.shell)]
        with m.If(accepts):
            m.d.sync += shell.eq(~0)

        def differ(bit):
            """Whether stages under way are of subshells whose numbers differ in this bit."""
            return (Cat(subshell[bit] for subshell in subshells) & stages.rays).any() & (
                Cat(~subshell[bit] for subshell in subshells) & stages.rays).any()

        # What is counted, registered first.
        waiting, several = Signal.like(memory.waiting), Signal()
        m.d.sync += [waiting.eq(memory.waiting), several.eq(Cat(differ(bit) for bit in range(index_bits)).any())]
        events = {
            "cycles": runs, "rays": leaves.valid & leaves.ready,
            "cells": sent & ~out.final, "deferrals": memory.waiting > waiting, "overlaps": several,
            "waits_for_survival": survival.i.valid & ~survival.i.ready, "waits_for_rays": lives.valid & ~lives.ready,
            "waits_for_traversal": leaves.valid & ~leaves.ready, "waits_for_cells": self.o.valid & ~self.o.ready}
        for name, event in events.items():
            counts = Signal(name=f"counts_{name}")
            m.d.sync += counts.eq(event)
            with m.If(counts):
                m.d.sync += self.counters[name].eq(self.counters[name] + 1)
        steps, requests = Signal.like(traversal.steps), Signal.like(request["count"])
        m.d.sync += [
            steps.eq(traversal.steps), self.counters.steps.eq(self.counters.steps + sum(steps)),
            requests.eq(Mux(takes, request["count"], 0)),
            self.counters.requests.eq(self.counters.requests + requests)]
        with m.If(accepts):
            m.d.sync += self.counters.eq(0)
        return m
