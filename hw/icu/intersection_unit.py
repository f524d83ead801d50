"""Intersection unit: the nearest hit of each ray of a section among all patches."""

from itertools import pairwise

from amaranth.hdl import Cat, Const, Module, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.ic_ray_generator import IcRayGenerator
from hw.icu.icu_formats import IcuFormats, TableKind
from hw.icu.intersection_pipeline import IntersectionPipeline
from hw.icu.patch_setup import PatchSetup
from hw.icu.patch_sums import PatchSums
from hw.icu.ray_memory import RayMemory
from hw.icu.read_out import ReadOut
from hw.icu.section_read_out import SectionReadOut
from hw.icu.settle_map import SettleMap
from hw.icu.vertex_gate import VertexGate
from hw.lib.checks import claim, count_entries, count_steps
from hw.lib.event_counters import EventCounters
from hw.lib.queue import Queue
from hw.lib.skid_buffer import SkidBuffer
from hw.lib.start_all import StartAll

__all__ = ["IntersectionUnit"]

# Done tokens that may be outstanding, from the ray generator's input to ``o_done``: enough for one patch per cycle.
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
                                                            '- PatchSums - o_sum

    To cast a frustum, write its tables, send its numbers and its patches, and count the done tokens: the cast is over
    when each patch has its token. The next frustum may be cast while this one is read out.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i_frustum : In, stream of `Formats.frustum`
        Begins a frustum. Accepted while no patch is in flight and its bank is not being read out; a shadow frustum
        when the last ray of its list has come.
    i_ray : In, stream of `IcuFormats.listed_ray`
        The rays of the shadow frustum that is offered, at least one item. Only with ``shadow_bits``.
    i_table : In, stream of `IcuFormats.table_write`
        Table entries. Accepted while no patch is in flight; weights also only while nothing is read out.
    i_vertex : In, stream of `Formats.patch_vertex`
        Patches: the four vertices of a patch follow each other. A patch is accepted while there is a frustum, none
        waits at ``i_frustum``, and the present one is not read out or requested to be.
    o_done : Out, stream of a patch id
        Done tokens: the patches in their order, each after its last ray has been written.
    i_read_out : In, stream without payload
        Reads out the present frustum when no patch is in flight. The next frustum is offered after it has been
        accepted.
    o_hit : Out, stream of `IcuFormats.read_ray`
        The rays of the section, row by row. They also go to the sums. Of a shadow frustum words of its list's rays, in
        their order.
    o_sum : Out, stream of `IcuFormats.section_sum`
        Those of each section that is read out, after its hits; see `PatchSums`.
    i_settle : In, stream of `Formats.tile`
        See `SettleMap`.
    o_settle : Out, stream of `Formats.settle_word`
        See `SettleMap`.
    patches : In(range(2^patch_bits + 1))
        Patches of the scene. Initially all that have a number; stable while patches are in flight or read out.
    counters : Out, struct of `COUNTERS`
        Since the frustum began.

    Timing
    ------
    A patch every four cycles, one ray per cycle, see `PatchSetup`, `IcRayGenerator` and `IntersectionPipeline`. A
    frustum is accepted ``5`` cycles after it is offered if nothing is in flight or read out; every
    2^``generation_bits`` - 1 frusta of a bank a cycle per ray of the section later, rounded up to a power of two, see
    `RayMemory`; a shadow frustum ``14`` cycles after the last of its rays. At most ``slots`` patches are in flight.

    Golden counterpart: `golden.engine.cast.naive_fixed.NaiveFixed`, `golden.engine.icu`. Source: Shen 1993, section
    5.3.5.
    """

    def __init__(self, *, config: Config):
        self._config, self._formats = config, IcuFormats(config)
        self._sums = PatchSums(config=config)
        formats = self._formats
        self._setup = PatchSetup(config=config)
        self._memory = RayMemory(config=config, tag=0)
        self._pipeline = IntersectionPipeline(config=config, update_latency=self._memory.latency)
        self._settle = SettleMap(config=config, tag=formats.tile_step)
        # From the last ray of a list until its code can be read: registers before and behind the memory.
        self.listed = 1 + self._memory.latency + 1 + self._settle.visible
        self._shadow = config.icu.shadow_bits > 0
        super().__init__({
            "i_frustum": In(stream.Signature(formats.frustum)),
            **({"i_ray": In(stream.Signature(formats.listed_ray))} if self._shadow else {}),
            "i_table": In(stream.Signature(formats.table_write)),
            "i_vertex": In(stream.Signature(formats.patch_vertex)),
            "o_done": Out(stream.Signature(formats.patch)),
            "i_read_out": In(stream.Signature(0)),
            "o_hit": Out(stream.Signature(formats.read_ray)),
            "o_sum": self._sums.signature.members["o"],
            "patches": In(self._sums.patches.shape(), init=1 << config.icu.patch_bits),
            "i_settle": In(stream.Signature(formats.tile)), "o_settle": Out(stream.Signature(formats.settle_word)),
            "counters": Out(StructLayout(dict.fromkeys(COUNTERS, COUNTER_BITS)))})

    def elaborate(self, platform):
        m = Module()
        formats = self._formats
        m.submodules.setup, m.submodules.pipeline = setup, pipeline = self._setup, self._pipeline
        m.submodules.memory = memory = self._memory
        m.submodules.generator = generator = IcRayGenerator(config=self._config)
        m.submodules.settle = settle = self._settle
        m.submodules.read_out = read_out = (SectionReadOut if self._shadow else ReadOut)(config=self._config)
        m.submodules.sums = sums = self._sums
        m.submodules.tokens = tokens = Queue(formats.patch, depth=TOKENS)
        m.submodules.gate = gate = VertexGate(config=self._config)

        # Patches in flight, from their first vertex until their token is accepted; and whether there is a frustum.
        frustum, has_frustum = Signal(formats.frustum), Signal()
        begun_patch, leaves = Signal(), Signal()
        in_flight = Signal(range(2 * (TOKENS + self._config.icu.slots)))
        # It rises some cycles after the last token, but is 0 from the cycle after a patch's first vertex on.
        was_drained, drained = Signal(init=1), Signal()
        m.d.sync += [begun_patch.eq(gate.begins), was_drained.eq((in_flight == 0) & ~begun_patch)]
        m.d.comb += drained.eq(was_drained & ~begun_patch)

        # A frustum begins when both memories have begun it.
        m.submodules.start = start = StartAll(count=2)
        may_begin, begun, accepts, reads = Signal(), Signal(), Signal(), Signal()
        # Once the banks have been swapped, the active bank is no longer the one that is read out.
        free = begun | ~(read_out.busy & (read_out.bank != memory.active))
        # Registered: the tiles of a section, rounded up to a power of two, are known two cycles after it.
        section, is_offered, known = self.i_frustum.payload.section, self.i_frustum.valid & ~accepts, Signal(2)
        icu, tiles = self._config.icu, Signal.like(settle.tiles)
        down = (section.end_row - section.first_row - 1)[:icu.side_bits] >> icu.tile_bits
        columns, rows = Signal(settle.tiles.shape().width), Signal(settle.tiles.shape().width)
        m.d.sync += [known.eq(Cat(is_offered, known[0] & is_offered)), tiles.eq(_product(columns, rows)),
                     columns.eq(_reaches(self.i_frustum.payload.tiles_across, len(columns))),
                     rows.eq(_successor_reaches(down, len(rows)))]
        m.d.comb += [
            settle.tiles.eq(tiles), memory.rays.eq(tiles << 2 * icu.tile_bits),
            # The tiles of the offered frustum are known.
            may_begin.eq(known[1] & drained & free & ~reads & ~accepts),
            self.i_frustum.ready.eq(accepts)]
        for output, unit in zip(start.o, (memory, settle), strict=True):
            wiring.connect(m, output, unit.i_start)
        # Registered, because much logic follows in both memories.
        lists, begins = Const(0), start.i.ready
        if self._shadow:
            listed, lists, begins = self._add_list(m, start.i.ready, accepts)
        m.d.comb += start.i.valid.eq(may_begin & ~lists)
        m.d.sync += accepts.eq(begins)
        with m.If(memory.i_start.valid & memory.i_start.ready):
            m.d.sync += begun.eq(1)
        with m.If(accepts):
            m.d.sync += [frustum.eq(self.i_frustum.payload), has_frustum.eq(1), begun.eq(0)]

        # Table entries are registered: their memories are far from the port.
        table, is_written, entry = self.i_table, Signal(), Signal(formats.table_write, reset_less=True)
        m.d.comb += table.ready.eq(drained & ~(read_out.busy & (table.payload.kind == TableKind.WEIGHT)))
        m.d.sync += [is_written.eq(table.valid & table.ready), entry.eq(table.payload)]
        for block in (setup, pipeline, sums):
            m.d.comb += [block.i_table.valid.eq(is_written), block.i_table.payload.eq(entry)]

        # Setup and rays.
        # The ray memory cannot update and read the same bank.
        read_now = Signal()
        m.d.sync += read_now.eq(self.i_read_out.valid | (read_out.busy & (read_out.bank == memory.active)))
        is_screen = Signal()
        # The source of vertices may be on the other side of the chip.
        m.submodules.vertices = vertices = SkidBuffer(formats.patch_vertex)
        wiring.connect(m, wiring.flipped(self.i_vertex), gate.i)
        wiring.connect(m, gate.o, vertices.i)
        wiring.connect(m, vertices.o, setup.i)
        m.d.comb += gate.is_open.eq(has_frustum & ~self.i_frustum.valid & ~read_now)
        if self._shadow:
            is_shadow = Signal()
            m.d.comb += [pipeline.is_shadow.eq(is_shadow), read_out.i.payload.is_list.eq(frustum.is_shadow)]
            m.d.sync += is_shadow.eq(frustum.is_shadow)
        m.d.comb += [setup.frustum.eq(frustum), setup.free.eq(pipeline.free), pipeline.is_screen.eq(is_screen)]
        m.d.sync += is_screen.eq(frustum.is_screen)
        for name, _ in formats.slot_record:
            wiring.connect(m, getattr(setup, f"o_{name}"), getattr(pipeline, f"i_{name}"))
        # Windows whose token is outstanding. The comparison is two cycles late: two windows may enter meanwhile.
        outstanding, enters, entered, has_credit = Signal(range(TOKENS + 1)), Signal(), Signal(), Signal()
        m.d.sync += [has_credit.eq(outstanding < TOKENS - 2), entered.eq(enters)]
        m.d.comb += [
            enters.eq(setup.o.valid & setup.o.ready), generator.i.valid.eq(setup.o.valid & has_credit),
            generator.i.payload.eq(setup.o.payload), setup.o.ready.eq(generator.i.ready & has_credit),
            generator.section.eq(frustum.section), generator.tiles_across.eq(frustum.tiles_across)]
        wiring.connect(m, generator.o_walk, settle.i_walk)
        wiring.connect(m, settle.o_walk, generator.i_walk)
        wiring.connect(m, generator.o, pipeline.i)

        # Write-back.
        update, answer = pipeline.o_update.payload, memory.o.payload
        m.d.comb += [memory.i.valid.eq(pipeline.o_update.valid), pipeline.i_update.valid.eq(memory.o.valid)]
        # A register ends the path through the comparison of distances; nothing depends on when codes are written.
        settles, settled = Signal(), Signal.like(settle.i.payload, reset_less=True)
        m.d.sync += [settles.eq(memory.o.valid & answer.won), settled.ray.eq(answer.ray),
                     settled.inverse.eq(answer.inverse)]
        m.d.comb += [settle.i.valid.eq(settles), settle.i.payload.eq(settled)]
        m.d.comb += [memory.i.payload[name].eq(update[name]) for name in ("ray", "inverse", "patch", "hit")]
        if self._shadow:
            # No patch is in flight while rays are listed. Their codes come from the memory like those of hits.
            with m.If(listed.valid):
                m.d.comb += [memory.i.valid.eq(1), memory.i.payload.lists.eq(1),
                             memory.i.payload.ray.eq(listed.payload.ray),
                             memory.i.payload.inverse.eq(listed.payload.end)]
        m.d.comb += [pipeline.i_update.payload[name].eq(answer[name]) for name in ("ray", "inverse", "won")]
        wiring.connect(m, pipeline.o_payload, memory.i_payload)
        m.d.comb += [tokens.i.valid.eq(pipeline.o_done.valid), tokens.i.payload.eq(pipeline.o_done.payload)]
        m.d.sync += leaves.eq(self.o_done.valid & self.o_done.ready)
        wiring.connect(m, tokens.o, wiring.flipped(self.o_done))
        count_entries(in_flight)
        count_steps(m, outstanding, up=entered, down=leaves, most=TOKENS)
        count_steps(m, in_flight, up=begun_patch, down=leaves, most=TOKENS + self._config.icu.slots)
        claim(m, ~tokens.i.valid | tokens.i.ready, "a token has an entry")

        # Read-out and sums.
        wiring.connect(m, wiring.flipped(self.i_settle), settle.i_read)
        wiring.connect(m, settle.o_read, wiring.flipped(self.o_settle))
        is_readable = has_frustum & drained & read_now & ~may_begin
        m.d.sync += reads.eq(self.i_read_out.valid & is_readable & read_out.i.ready & ~reads)
        m.d.comb += [
            read_out.i.valid.eq(reads), self.i_read_out.ready.eq(reads), read_out.i.payload.bank.eq(memory.active),
            read_out.i.payload.section.eq(frustum.section), read_out.i.payload.tiles_across.eq(frustum.tiles_across)]
        wiring.connect(m, read_out.o_read, memory.i_read)
        wiring.connect(m, memory.o_read, read_out.i_hit)
        found = read_out.o
        m.d.comb += [
            self.o_hit.valid.eq(found.valid & sums.i.ready), self.o_hit.payload.eq(found.payload),
            sums.i.valid.eq(found.valid & self.o_hit.ready), sums.i.payload.row.eq(found.payload.row),
            sums.i.payload.hit.eq(found.payload.hit), found.ready.eq(self.o_hit.ready & sums.i.ready)]
        wiring.connect(m, sums.o, wiring.flipped(self.o_sum))
        m.d.comb += sums.patches.eq(self.patches)
        # The sums of a section are read when its last hit has been added.
        ends = Signal()
        with m.If(found.valid & found.ready & found.payload.last):
            m.d.sync += ends.eq(1)
        with m.Elif(sums.i_read.ready):
            m.d.sync += ends.eq(0)
        m.d.comb += sums.i_read.valid.eq(ends)

        issued = generator.o.valid & generator.o.payload.is_ray
        events = {"cycles": ~drained, "patches": leaves, "visited": generator.visited, "issued": issued,
                  "tested": pipeline.tested, "inside": pipeline.inside, "won": memory.o.valid & answer.won,
                  "waits_for_slot": self.i_vertex.valid & ~self.i_vertex.ready & has_frustum,
                  "waits_for_rays": ~drained & ~issued}
        m.submodules.counters = counters = EventCounters(
            {name: Value.cast(event).shape() for name, event in events.items()}, bits=COUNTER_BITS)
        for name, event in events.items():
            m.d.comb += [counters.events[name].eq(event), self.counters[name].eq(counters.counters[name])]
        m.d.sync += counters.clear.eq(accepts)
        return m

    def _add_list(self, m, begun, accepts):
        """The rays of a shadow frustum that the memories have ``begun``. Gives those that are written, as a stream
        without ready, whether it ``lists`` rays, and whether it ``begins`` the frustum, of whatever kind.
        """
        memory, settle, pipeline = m.submodules.memory, m.submodules.settle, m.submodules.pipeline
        place = m.submodules.read_out.i_ray
        given, is_shadow, is_last = self.i_ray, self.i_frustum.payload.is_shadow, Signal()
        listed = Signal(StructLayout({"valid": 1, "payload": given.payload.shape()}))
        # The last ray is known a cycle later.
        last = self.listed - 1
        waits, lists, begins = Signal(range(last + 1)), Signal(), Signal()
        comes = given.valid & given.ready
        m.d.comb += [
            memory.is_shadow.eq(is_shadow), given.ready.eq(lists & ~is_last),
            begins.eq((begun & ~is_shadow) | (lists & (waits == last) & ~accepts)),
            pipeline.i_ray.valid.eq(listed.valid),
            *(pipeline.i_ray.payload[name].eq(listed.payload[name]) for name in ("ray", "x", "y")),
            place.valid.eq(comes), place.payload.bank.eq(memory.active),
            *(place.payload[name].eq(given.payload[name]) for name in ("ray", "is_ray", "last"))]
        m.d.sync += [listed.valid.eq(comes & given.payload.is_ray), listed.payload.eq(given.payload),
                     waits.eq(waits + (is_last & (waits != last)))]
        with m.If(begun):
            m.d.sync += [settle.settled.eq(is_shadow), lists.eq(is_shadow)]
        with m.If(comes & given.payload.last):
            m.d.sync += is_last.eq(1)
        with m.If(accepts):
            m.d.sync += [lists.eq(0), is_last.eq(0), waits.eq(0)]
        return listed, lists, begins


def _reaches(number, count):
    """``count`` bits: bit k says whether ``number``, rounded up to a power of two, is at least 2^k."""
    number = Cat(number, Const(0, count))
    return Cat(Const(1), *(number[k + 1:].any() | (number[k] & number[:k].any()) for k in range(count - 1)))


def _successor_reaches(number, count):
    """`_reaches` of ``number`` + 1, without an adder."""
    number = Cat(number, Const(0, count))
    return Cat(Const(1), *(number[k:].any() for k in range(count - 1)))


def _product(columns, rows):
    """The product of two powers of two, each given as by `_reaches`; at most the largest one that the width holds."""
    reaches = [Cat(columns[k] & rows[n - k] for k in range(n + 1)).any() for n in range(len(rows))]
    return Cat(*(at_least & ~more for at_least, more in pairwise([*reaches, Const(0)])))
