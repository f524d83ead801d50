"""Ray traversal: from requests for grid rays to cells."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.ctu.cell_traversal import CellTraversal
from hw.ctu.ctu_formats import CtuFormats
from hw.ctu.grid_direction import GridDirection
from hw.ctu.grid_entries import GridEntries
from hw.ctu.ray_banks import RayBanks
from hw.ctu.stage_count import NEAR_STAGE, StageCount, stage_index_bits
from hw.ctu.survival import Survival
from hw.lib.skid_buffer import SkidBuffer
from hw.lib.start_all import StartAll

__all__ = ["COUNTERS", "RayTraversal"]

# Since the beginning of the frustum, with what each one counts.
COUNTERS = {
    "cycles": "cycles until the last cell", "requests": "grid rays requested", "rays": "grid rays traversed",
    "steps": "steps from cell to cell", "cells": "cells opened",
    "deferrals": "requests deferred until a grid ray returned",
    "overlaps": "cycles in which grid rays of several subshells were in flight",
    "waits_for_survival": "cycles in which a request stalled at the survival test",
    "waits_for_rays": "cycles in which a surviving ray stalled at the ray memory",
    "waits_for_traversal": "cycles in which a ray stalled at the traversal pipelines",
    "waits_for_cells": "cycles in which an opened cell stalled at the memory system"}
COUNTER_BITS = 32


class RayTraversal(wiring.Component):
    """The back end of cell traversal.

    ::

        i - Survival - RayBanks - GridEntries - GridDirection - CellTraversal -+- o
                          '--------------- last item of a ray -----------------'
        i_near ----------------------------------------------------------------'

    A frustum: write its tables, give its numbers, send the near cells and the requests. It ends with the final item.

    Without subshell lists (``ctu.subshell_bits`` of 0) each grid ray is requested once. Then there is no `RayBanks`,
    and the counters ``deferrals`` and ``overlaps`` stay 0.

    Parameters
    ----------
    config
        The configuration.
    pipelines
        See `CellTraversal`.

    Members
    -------
    i_frustum : In, stream of TraversalFrustum
        A frustum (`CtuFormats.traversal_frustum`). Accepted when the one before is over. The intersection unit has
        begun the frustum before.
    i_table : In, stream of GridTableWrite
        Table entries. Always ready; not during a frustum.
    i_near : In, stream of NearCell
        The cells of shell 1, before all requests.
    i : In, stream of GridRequest
        Requests, accepted behind the near cells; with a run-ahead depth of 0 when the near cells' stage is over.
    o_over : Out, stream without payload
        A stage of requests is over. Always ready.
    o : Out, stream of MetCell
        Cells; the near cells have the stage before the first request's.
    closed : Out(1)
        All requests of the frustum have been accepted, and it is not over.
    settled : In(1)
        See `StageCount`.
    o_tile : Out, stream of Tile
        Reads of the settle map.
    i_word : In, stream of SettleWord
        Their words.
    counters : Out, struct of `COUNTERS`
        The counters, since the frustum began.

    Timing
    ------
    Latency: ``5 * product_registers + 64 + 10 * (subshell_bits > 0)`` cycles from a request for a ray alone to its
    first cell, with several pipelines 1 more. One request, one ray and one cell per cycle; stalls with ``o``. With
    lists a frustum begins ``ray_slots`` cycles later after reset and every 2^``generation_bits`` - 1 frusta.

    Golden counterpart: `golden.engine.ctu.unit.CellTraversalUnit.open`. Source: Shen 1993, section 5.3.4.
    """

    def __init__(self, *, config: Config, pipelines: int = 1):
        self._config, self._formats = config, CtuFormats(config)
        formats, ctu = self._formats, config.ctu
        entry = {"shell": formats.shell, "row": formats.grid_row_address, "column": formats.grid_column_address}
        self._ray = StructLayout({"stage": formats.stage, "ray": formats.grid_number, **entry})
        self._slot_bits = ctu.ray_slots.bit_length() - 1
        self._memory, sent = None, StructLayout({"stage": formats.stage})
        self._survival = Survival(config=config, ray=self._ray)
        if ctu.subshells:
            self._memory = RayBanks(
                slots=ctu.ray_slots, version_bits=formats.grid_number.width - self._slot_bits + 1,
                deferred=ctu.deferred, generation_bits=config.icu.generation_bits,
                tag=StructLayout({"stage": formats.stage, **entry}))
            self._sent = SkidBuffer(self._memory.o.payload.shape())
            sent = StructLayout({"stage": formats.stage, "slot": self._slot_bits})
        segment = StructLayout({"sent": sent, "begin": formats.begin, "length": formats.parameter})
        self._entries, self._direction = GridEntries(config=config, tag=sent), GridDirection(config=config, tag=segment)
        self._traversal = CellTraversal(config=config, tag=sent, pipelines=pipelines)
        super().__init__({
            "i_frustum": In(stream.Signature(formats.traversal_frustum)),
            "i_table": In(self._survival.i_table.signature.flip()),
            "i_near": In(stream.Signature(formats.near_cell)), "i": In(stream.Signature(formats.grid_request)),
            "o_over": Out(stream.Signature(0, always_ready=True)), "o": Out(stream.Signature(formats.met_cell)),
            "closed": Out(1), "settled": In(1), "o_tile": Out(stream.Signature(formats.tile)),
            "i_word": In(stream.Signature(formats.settle_word)),
            "counters": Out(StructLayout(dict.fromkeys(COUNTERS, COUNTER_BITS)))})
        self.latency = sum(block.latency for block in (
            self._survival, *((self._memory, self._sent) if self._memory else ()), self._entries, self._direction,
            self._traversal))

    def elaborate(self, platform):
        m = Module()
        m.submodules.survival, m.submodules.entries = self._survival, self._entries
        m.submodules.direction, m.submodules.traversal = self._direction, self._traversal
        if self._memory:
            m.submodules.memory, m.submodules.sent = self._memory, self._sent
        passed = len(self._memory.o_passed) if self._memory else 0
        m.submodules.stages = stages = StageCount(
            config=self._config, exits=self._config.ctu.pyramid_levels + passed + 1)

        runs, begins, accepts = Signal(), Signal(), Signal()
        m.d.comb += stages.begins.eq(begins)
        self._add_frustum(m, runs=runs, begins=begins)
        near_closed = self._add_requests(m, stages, runs=runs, begins=begins, accepts=accepts)
        waits = self._add_rays(m)
        self._add_cells(m, stages, runs=runs, near_closed=near_closed)
        events = {"cycles": runs, **waits}
        if self._memory:
            waiting = Signal.like(self._memory.waiting)
            m.d.sync += waiting.eq(self._memory.waiting)
            events |= {"deferrals": self._memory.waiting > waiting,
                       "overlaps": self._add_overlaps(m, stages, begins=begins, accepts=accepts)}
        self._add_counters(m, events, begins=begins, accepts=accepts)
        return m

    def _add_frustum(self, m, *, runs, begins):
        """A frustum begins when survival and the ray memory have begun it."""
        given, frustum = self.i_frustum, Signal(self._formats.traversal_frustum)
        blocks = [self._survival, *([self._memory] if self._memory else [])]
        m.submodules.start = start = StartAll(count=len(blocks))
        m.d.comb += [start.i.valid.eq(given.valid & ~runs & ~begins), given.ready.eq(begins)]
        m.d.sync += begins.eq(start.i.ready)
        with m.If(start.i.valid):
            m.d.sync += frustum.eq(given.payload)
        for output, block in zip(start.o, blocks, strict=True):
            wiring.connect(m, output, block.i_start)
        with m.If(begins):
            m.d.sync += runs.eq(1)
        m.d.comb += [self._survival.frustum.eq(frustum.frustum), self._survival.runs.eq(runs)]
        # Registered: no ray is there in the first cycle.
        m.d.sync += [self._direction.is_screen.eq(frustum.frustum.is_screen),
                     self._direction.to_global.eq(frustum.to_global),
                     self._traversal.origin.eq(frustum.grid_origin), self._traversal.shape.eq(frustum.cells)]
        for block in self._survival, self._entries:
            m.d.comb += [block.i_table.valid.eq(self.i_table.valid), block.i_table.payload.eq(self.i_table.payload)]
        wiring.connect(m, self._survival.o_tile, wiring.flipped(self.o_tile))
        wiring.connect(m, wiring.flipped(self.i_word), self._survival.i_word)

    def _add_requests(self, m, stages, *, runs, begins, accepts):
        """Near cells, then requests; a request without rays only closes its stage."""
        # Open: behind the near cells, until the final request.
        near_closed, all_closed, is_open, some, may = Signal(), Signal(), Signal(), Signal(), Signal()
        request, rays = self.i.payload, self._survival.i
        m.d.comb += [
            accepts.eq(self.i.valid & self.i.ready), some.eq(request["count"].any()),
            may.eq(is_open & (1 if self._config.ctu.run_ahead else stages.near_over)),
            rays.valid.eq(self.i.valid & may & some), self.i.ready.eq(may & (rays.ready | ~some)),
            *(rays.payload.first[name].eq(request[name]) for name in self._ray.members),
            rays.payload["count"].eq(request["count"]),
            stages.enters.valid.eq(accepts & some), stages.enters.payload["count"].eq(request["count"]),
            stages.enters.payload.stage.eq(request.stage)]
        near_closes = self.i_near.valid & self.i_near.ready & self.i_near.payload.last
        m.d.comb += [self.closed.eq(runs & all_closed), stages.closed_all.eq(all_closed),
                     stages.closes.eq(near_closes | (accepts & request.last)), stages.settled.eq(self.settled),
                     self.o_over.valid.eq(stages.over & stages.near_over)]
        with m.If(near_closes):
            m.d.sync += [near_closed.eq(1), is_open.eq(1)]
        with m.If(accepts & request.final):
            m.d.sync += [all_closed.eq(1), is_open.eq(0)]
        with m.If(begins):
            m.d.sync += [near_closed.eq(0), all_closed.eq(0)]
        return near_closed

    def _add_rays(self, m):
        """From survival to traversal; what waits where, by counter."""
        survived, entries = self._survival.o, self._entries.i
        if self._memory:
            memory, sent, bits = self._memory, self._sent.o, self._slot_bits
            wiring.connect(m, memory.o, self._sent.i)
            ray = sent.payload.tag
            m.d.comb += [
                memory.i.valid.eq(survived.valid), survived.ready.eq(memory.i.ready),
                memory.i.payload.slot.eq(survived.payload.ray[:bits]),
                # Version 0 is that of a slot that no ray has left.
                memory.i.payload.version.eq((survived.payload.ray >> bits) + 1),
                *(memory.i.payload.tag[name].eq(survived.payload[name]) for name in ray.shape().members),
                entries.payload.tag.slot.eq(sent.payload.slot)]
        else:
            sent, ray = survived, survived.payload
        m.d.comb += [
            entries.valid.eq(sent.valid), sent.ready.eq(entries.ready), entries.payload.tag.stage.eq(ray.stage),
            *(entries.payload[name].eq(ray[name]) for name in ("shell", "row", "column"))]
        found, turned, direction, traversal = self._entries.o, self._direction.o, self._direction.i, self._traversal.i
        m.d.comb += [
            direction.valid.eq(found.valid), found.ready.eq(direction.ready),
            *(direction.payload[name].eq(found.payload[name]) for name in ("row", "column")),
            direction.payload.tag.sent.eq(found.payload.tag),
            *(direction.payload.tag[name].eq(found.payload[name]) for name in ("begin", "length")),
            traversal.valid.eq(turned.valid), turned.ready.eq(traversal.ready),
            traversal.payload.tag.eq(turned.payload.tag.sent),
            traversal.payload.direction.eq(turned.payload.direction),
            *(traversal.payload[name].eq(turned.payload.tag[name]) for name in ("begin", "length"))]
        requests = self._survival.i
        return {"rays": sent.valid & sent.ready, "waits_for_survival": requests.valid & ~requests.ready,
                "waits_for_traversal": sent.valid & ~sent.ready,
                **({"waits_for_rays": survived.valid & ~survived.ready} if self._memory else {})}

    def _add_cells(self, m, stages, *, runs, near_closed):
        """Cells; the last item of a ray ends it."""
        met, near, out = self._traversal.o, self.i_near, self.o.payload
        ends = Signal()
        m.d.comb += [
            near.ready.eq(runs & ~near_closed & (self.o.ready | ~near.payload.is_cell)),
            # No ray is there before the near cells are over.
            met.ready.eq(self.o.ready | ~met.payload.is_cell),
            self.o.valid.eq(Mux(near_closed, (met.valid & met.payload.is_cell) | (runs & stages.done & ~met.valid),
                                runs & near.valid & near.payload.is_cell)),
            out.cell.eq(Mux(near_closed, met.payload.cell, near.payload.cell)),
            out.stage.eq(Mux(near_closed, met.payload.tag.stage, NEAR_STAGE)), out.final.eq(near_closed & ~met.valid),
            ends.eq(met.valid & met.ready & met.payload.last)]
        with m.If(self.o.valid & self.o.ready & out.final):
            m.d.sync += runs.eq(0)
        exits = [(one.valid, one.payload.first.stage, one.payload["count"]) for one in (
            getattr(self._survival, f"o_dropped_{level}") for level in range(self._config.ctu.pyramid_levels))]
        if self._memory:
            back = self._memory.i_return
            m.d.sync += [back.valid.eq(ends), back.payload.eq(met.payload.tag.slot)]
            exits += [(one.valid, one.payload.stage, 1) for one in self._memory.o_passed]
        exits.append((ends, met.payload.tag.stage, 1))
        for port, (valid, stage, count) in zip(stages.left, exits, strict=True):
            m.d.comb += [port.valid.eq(valid), port.payload.stage.eq(stage), port.payload["count"].eq(count)]

    def _add_overlaps(self, m, stages, *, begins, accepts):
        """Whether grid rays of several subshells are in flight.

        A stage is of a new subshell if its shell does not come behind the shell of the stage before it.
        """
        request, bits = self.i.payload, stage_index_bits(self._config)
        before, shell, present = Signal(bits), Signal(request.shell.shape()), Signal(bits)
        subshells = [Signal(bits, name=f"subshell_{index}") for index in range(1 << bits)]
        m.d.comb += present.eq(before + (request.shell <= shell))
        with m.If(accepts & request["count"].any()):
            for index, subshell in enumerate(subshells):
                with m.If(request.stage[:bits] == index):
                    m.d.sync += subshell.eq(present)
        with m.If(accepts & request.last):
            m.d.sync += [before.eq(present), shell.eq(request.shell)]
        with m.If(begins):
            m.d.sync += shell.eq(~0)

        def differ(bit):
            """Whether stages in flight are of subshells whose numbers differ in this bit."""
            return (Cat(subshell[bit] for subshell in subshells) & stages.rays).any() & (
                Cat(~subshell[bit] for subshell in subshells) & stages.rays).any()

        several = Signal()
        m.d.sync += several.eq(Cat(differ(bit) for bit in range(bits)).any())
        return several

    def _add_counters(self, m, events, *, begins, accepts):
        """Events are registered twice before they are counted: where they are seen, and where the counters are."""
        counters, out = self.counters, self.o
        events |= {"cells": out.valid & out.ready & ~out.payload.final, "waits_for_cells": out.valid & ~out.ready}
        for name, event in events.items():
            seen, counts = Signal(name=f"sees_{name}"), Signal(name=f"counts_{name}")
            m.d.sync += [seen.eq(event), counts.eq(seen)]
            with m.If(counts):
                m.d.sync += counters[name].eq(counters[name] + 1)
        steps, requests = Signal.like(self._traversal.steps), Signal.like(self.i.payload["count"])
        accepted, rays = Signal(), Signal.like(requests)
        m.d.sync += [
            steps.eq(self._traversal.steps), counters.steps.eq(counters.steps + sum(steps)),
            accepted.eq(accepts), rays.eq(self.i.payload["count"]), requests.eq(Mux(accepted, rays, 0)),
            counters.requests.eq(counters.requests + requests)]
        with m.If(begins):
            m.d.sync += counters.eq(0)
