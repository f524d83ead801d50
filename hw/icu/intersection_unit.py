"""Intersection unit: patches in, the nearest hit of each ray of a section out."""

from amaranth.hdl import Module, Mux, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.icu.collector import Collector
from hw.icu.ic_ray_generator import IcRayGenerator
from hw.icu.icu_formats import IcuFormats, TableKind
from hw.icu.intersection_pipeline import IntersectionPipeline
from hw.icu.patch_setup import PatchSetup
from hw.icu.ray_memory import BANKS, RayMemory
from hw.icu.read_out import ReadOut
from hw.icu.settle_map import SettleMap
from hw.lib.queue import Queue
from hw.lib.skid_buffer import SkidBuffer

__all__ = ["IntersectionUnit"]

# Patches between the ray generator's input and the taker of the done tokens: enough for one per cycle.
TOKENS = 128
# Since the beginning of the frustum, with what each one counts.
COUNTERS = {
    "cycles": "cycles until the last patch was done", "patches": "patches", "visited": "rays of the patches' windows",
    "issued": "rays issued", "tested": "intersection tests", "inside": "tests that hit their patch",
    "won": "hits nearer than the ray's best one",
    "waits_for_slot": "cycles in which a vertex stalled for a patch slot",
    "waits_for_rays": "cycles with patches in flight and no ray issued"}
COUNTER_BITS = 32


class IntersectionUnit(wiring.Component):
    """The Intersection Computation Unit of one cluster.

    ::

        i_vertex - PatchSetup - IcRayGenerator - IntersectionPipeline - o_done
                                     |                |       |
                                 SettleMap <------ RayMemory -'
                                     |                |
                                  o_settle         ReadOut -+- o_hit
                                                            '- Collector - o_sum

    A frustum: write its tables, give its numbers, send patches, count the tokens. It is over when each patch has its
    token. The next one may begin while the last one is read out.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i_frustum
        `Formats.frustum`. Taken when no patch is under way and its bank is not being read out.
    i_table
        `IcuFormats.table_write`. Taken while no patch is under way, weights while nothing is read out.
    i_vertex
        `Formats.patch_vertex`, the four vertices of a patch one after the other. Taken when there is a frustum, none
        waits at ``i_frustum``, and the present one is not being read out or about to be.
    o_done
        The patches in their order, each after its last ray has been written.
    i_read_out
        1: of the frustum before the present one, taken when there was one; 0: of the present one, taken when no patch
        is under way.
    o_hit
        ``column``, ``row``, ``hit`` (`IcuFormats.hit`), ``last``: the rays of the section, row by row. They also go to
        the collector.
    i_sums, o_sum
        See `Collector`; taken while nothing is read out.
    i_settle, o_settle
        See `SettleMap`.
    counters
        `COUNTERS`.

    Timing
    ------
    A quad every four cycles, one ray per cycle, see `PatchSetup`, `IcRayGenerator` and `IntersectionPipeline`. After
    reset, and every 2^``generation_bits`` - 1 frusta of a bank, a frustum begins ``rays`` cycles later. ``slots``
    patches are under way at most.

    Golden counterpart: `golden.cast.naive_fixed.NaiveFixed`, `golden.icu`. Source: Shen 1993, section 5.3.5.
    """

    def __init__(self, *, config: Config):
        self._config, self._formats = config, IcuFormats(config)
        formats = self._formats
        self._setup = PatchSetup(config=config)
        self._memory = RayMemory(config=config, tag=0)
        self._pipeline = IntersectionPipeline(config=config, update_latency=self._memory.latency)
        super().__init__({
            "i_frustum": In(stream.Signature(formats.frustum)),
            "i_table": In(stream.Signature(formats.table_write)),
            "i_vertex": In(stream.Signature(formats.patch_vertex)),
            "o_done": Out(stream.Signature(formats.patch)),
            "i_read_out": In(stream.Signature(1)),
            "o_hit": Out(stream.Signature(StructLayout({"column": formats.index, "row": formats.index,
                                                        "hit": formats.hit, "last": 1}))),
            "i_sums": In(stream.Signature(config.icu.patch_bits + 1)),
            "o_sum": Out(stream.Signature(formats.patch_sum)),
            "i_settle": In(stream.Signature(formats.tile)), "o_settle": Out(stream.Signature(formats.settle_word)),
            "counters": Out(StructLayout(dict.fromkeys(COUNTERS, COUNTER_BITS)))})

    def elaborate(self, platform):
        m = Module()
        formats = self._formats
        m.submodules.setup, m.submodules.pipeline = setup, pipeline = self._setup, self._pipeline
        m.submodules.memory = memory = self._memory
        m.submodules.generator = generator = IcRayGenerator(config=self._config)
        m.submodules.settle = settle = SettleMap(config=self._config, tag=formats.tile_step)
        m.submodules.read_out = read_out = ReadOut(config=self._config)
        m.submodules.collector = collector = Collector(config=self._config)
        m.submodules.tokens = tokens = Queue(formats.patch, depth=TOKENS)

        # Patches that have come, and of these the ones with a window, whose token has not been taken.
        frustum, there, earlier = Signal(formats.frustum), Signal(), Signal()
        comes, came, enters, leaves = Signal(), Signal(), Signal(), Signal()
        under_way, owed = Signal(range(2 * (TOKENS + self._config.icu.slots))), Signal(range(TOKENS + 1))
        # A cycle after the last token, but no cycle after the first vertex.
        none_left, drained = Signal(init=1), Signal()
        m.d.sync += [came.eq(comes), none_left.eq((under_way == 0) & ~came)]
        m.d.comb += drained.eq(none_left & ~came)

        # A frustum begins when both memories have.
        begins, memory_begins, settle_begins, reads = Signal(), Signal(), Signal(), Signal()
        begun, settle_begun, accepts = Signal(), Signal(), Signal()
        # Once the banks have changed places it is no longer the frustum's own that may be read.
        free = begun | ~(read_out.busy & (read_out.bank != memory.active))
        m.d.comb += [
            begins.eq(self.i_frustum.valid & drained & free & ~reads),
            memory.i_start.valid.eq(begins & ~begun), settle.i_start.valid.eq(begins & ~settle_begun),
            memory_begins.eq(memory.i_start.valid & memory.i_start.ready),
            settle_begins.eq(settle.i_start.valid & settle.i_start.ready),
            self.i_frustum.ready.eq(accepts)]
        m.d.sync += accepts.eq(begins & begun & settle_begun & ~accepts)
        with m.If(memory_begins):
            m.d.sync += begun.eq(1)
        with m.If(settle_begins):
            m.d.sync += settle_begun.eq(1)
        sections = [Signal(StructLayout({"section": formats.section, "tiles_across": formats.count}))
                    for _ in range(BANKS)]
        with m.If(accepts):
            m.d.sync += [frustum.eq(self.i_frustum.payload), there.eq(1), earlier.eq(there), begun.eq(0),
                         settle_begun.eq(0)]
            for bank, kept in enumerate(sections):
                with m.If(memory.active == bank):
                    m.d.sync += [kept.section.eq(self.i_frustum.payload.section),
                                 kept.tiles_across.eq(self.i_frustum.payload.tiles_across)]

        # Tables.
        table = self.i_table
        m.d.comb += table.ready.eq(drained & ~(read_out.busy & (table.payload.kind == TableKind.WEIGHT)))
        for block in (setup, pipeline, collector):
            m.d.comb += [block.i_table.valid.eq(table.valid & table.ready), block.i_table.payload.eq(table.payload)]

        # Setup and rays.
        # The ray memory cannot update and read the same bank.
        asks_now, read_now = self.i_read_out.valid & ~self.i_read_out.payload, Signal()
        m.d.sync += read_now.eq(asks_now | (read_out.busy & (read_out.bank == memory.active)))
        takes = there & ~self.i_frustum.valid & ~read_now
        # A patch of which some vertices have been taken goes on.
        goes_on, vertex, is_screen = Signal(), Signal(2), Signal()
        # What sends vertices may be on the other side of the chip.
        m.submodules.taken = taken = SkidBuffer(formats.patch_vertex)
        wiring.connect(m, taken.o, setup.i)
        m.d.comb += [goes_on.eq(vertex != 0), taken.i.valid.eq(self.i_vertex.valid & (takes | goes_on)),
                     taken.i.payload.eq(self.i_vertex.payload),
                     self.i_vertex.ready.eq(taken.i.ready & (takes | goes_on))]
        with m.If(taken.i.valid & taken.i.ready):
            m.d.sync += vertex.eq(vertex + 1)
        m.d.comb += [setup.frustum.eq(frustum), setup.free.eq(pipeline.free), pipeline.is_screen.eq(is_screen)]
        m.d.sync += is_screen.eq(frustum.is_screen)
        for name, _ in formats.slot_record:
            wiring.connect(m, getattr(setup, f"o_{name}"), getattr(pipeline, f"i_{name}"))
        # Known a cycle before: while a window enters, another one may.
        room = Signal()
        m.d.sync += room.eq(owed < TOKENS - 1)
        m.d.comb += [
            enters.eq(setup.o.valid & setup.o.ready), generator.i.valid.eq(setup.o.valid & room),
            generator.i.payload.eq(setup.o.payload), setup.o.ready.eq(generator.i.ready & room),
            generator.section.eq(frustum.section), generator.tiles_across.eq(frustum.tiles_across)]
        wiring.connect(m, generator.o_walk, settle.i_walk)
        wiring.connect(m, settle.o_walk, generator.i_walk)
        wiring.connect(m, generator.o, pipeline.i)

        # Write-back.
        update, answer = pipeline.o_update.payload, memory.o.payload
        m.d.comb += [memory.i.valid.eq(pipeline.o_update.valid), pipeline.i_update.valid.eq(memory.o.valid)]
        # The comparison of distances ends here; nobody waits for the settle map.
        settles, settled = Signal(), Signal.like(settle.i.payload, reset_less=True)
        m.d.sync += [settles.eq(memory.o.valid & answer.won), settled.ray.eq(answer.ray),
                     settled.inverse.eq(answer.inverse)]
        m.d.comb += [settle.i.valid.eq(settles), settle.i.payload.eq(settled)]
        m.d.comb += [memory.i.payload[name].eq(update[name]) for name in ("ray", "inverse", "patch", "hit")]
        m.d.comb += [pipeline.i_update.payload[name].eq(answer[name]) for name in ("ray", "inverse", "won")]
        wiring.connect(m, pipeline.o_payload, memory.i_payload)
        m.d.comb += [tokens.i.valid.eq(pipeline.o_done.valid), tokens.i.payload.eq(pipeline.o_done.payload)]
        m.d.sync += leaves.eq(self.o_done.valid & self.o_done.ready)
        wiring.connect(m, tokens.o, wiring.flipped(self.o_done))
        m.d.comb += comes.eq(taken.i.valid & taken.i.ready & (vertex == 0))
        m.d.sync += [owed.eq(owed + enters - leaves), under_way.eq(under_way + came - leaves)]

        # Read-out and collector.
        wiring.connect(m, wiring.flipped(self.i_settle), settle.i_read)
        wiring.connect(m, settle.o_read, wiring.flipped(self.o_settle))
        bank = memory.active ^ self.i_read_out.payload
        asked = there & Mux(self.i_read_out.payload, earlier, drained & read_now) & ~begins
        m.d.sync += reads.eq(self.i_read_out.valid & asked & read_out.i.ready & ~reads)
        m.d.comb += [read_out.i.valid.eq(reads), self.i_read_out.ready.eq(reads), read_out.i.payload.bank.eq(bank)]
        for name in ("section", "tiles_across"):
            m.d.comb += read_out.i.payload[name].eq(Mux(bank, sections[1][name], sections[0][name]))
        wiring.connect(m, read_out.o_ask, memory.i_read)
        wiring.connect(m, memory.o_read, read_out.i_hit)
        found = read_out.o
        m.d.comb += [
            self.o_hit.valid.eq(found.valid & collector.i.ready), self.o_hit.payload.eq(found.payload),
            collector.i.valid.eq(found.valid & self.o_hit.ready), collector.i.payload.row.eq(found.payload.row),
            collector.i.payload.hit.eq(found.payload.hit), found.ready.eq(self.o_hit.ready & collector.i.ready),
            collector.i_read.valid.eq(self.i_sums.valid & ~read_out.busy),
            collector.i_read.payload.eq(self.i_sums.payload),
            self.i_sums.ready.eq(collector.i_read.ready & ~read_out.busy)]
        wiring.connect(m, collector.o, wiring.flipped(self.o_sum))

        issued = generator.o.valid & generator.o.payload.is_ray
        events = {"cycles": ~drained, "patches": leaves, "visited": generator.visited, "issued": issued,
                  "tested": pipeline.tested, "inside": pipeline.inside, "won": memory.o.valid & answer.won,
                  "waits_for_slot": self.i_vertex.valid & ~self.i_vertex.ready & there,
                  "waits_for_rays": ~drained & ~issued}
        clears = Signal()
        m.d.sync += clears.eq(accepts)
        for name, event in events.items():
            # Events come from all over the unit, with a cycle for the way.
            counter, count = self.counters[name], Signal.like(Value.cast(event), name=f"counted_{name}")
            m.d.sync += [count.eq(event), counter.eq(counter + count)]
            with m.If(clears):
                m.d.sync += counter.eq(0)
        return m
