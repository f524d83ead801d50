"""Cluster: casts one section after the other, and writes its own results."""

from amaranth.hdl import Cat, Module, Mux, ResetInserter, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.control.cluster_faults import ClusterFaults
from hw.control.control_formats import ControlFormats
from hw.control.frustum_load import FrustumLoad
from hw.control.frustum_slot import FrustumSlot
from hw.control.job_formats import WORD_BITS, JobFormats
from hw.control.near_cell_banks import NearCellBanks
from hw.control.section_cast import SectionCast
from hw.control.section_results import COUNTS, SectionResults
from hw.ctu.ctu_formats import CtuFormats
from hw.ctu.ray_traversal import COUNTERS as TRAVERSAL_COUNTERS
from hw.ctu.subshell_table import SubshellTable
from hw.ctu.subshell_windows import VERTICES
from hw.ctu.traversal_unit import TraversalUnit
from hw.icu.icu_formats import IcuFormats
from hw.icu.intersection_unit import COUNTERS as INTERSECTION_COUNTERS
from hw.icu.intersection_unit import IntersectionUnit
from hw.icu.ray_list import RayList
from hw.lib.arbiter import Arbiter
from hw.lib.checks import claim
from hw.lib.queue import Queue
from hw.lib.skid_buffer import SkidBuffer
from hw.memsys.load.image_layout import RegionNumber
from hw.memsys.load.table_load import TableLoad
from hw.memsys.memory_system import COUNTERS as MEMORY_COUNTERS
from hw.memsys.memory_system import MemorySystem
from hw.memsys.patches.path_formats import PathFormats
from hw.memsys.port.memory_formats import MemoryFormats
from hw.memsys.results.result_writer import ResultWriter
from hw.registers.counter_choice import CounterChoice
from hw.registers.engine_registers import COUNTER_BITS

__all__ = ["COUNTERS", "RECORDED", "UNIT_COUNTERS", "Cluster", "cluster_members"]

UNIT_COUNTERS = {"intersection": INTERSECTION_COUNTERS, "traversal": TRAVERSAL_COUNTERS, "memory": MEMORY_COUNTERS}
# All counters of a cluster by name, with what each one counts.
COUNTERS = {"cycles": "cycles of the section"} | {
    f"{unit}_{name}": about for unit, counters in UNIT_COUNTERS.items() for name, about in counters.items()}

# Of a completion record: its fields that are counters, and their names in `COUNTERS`.
RECORDED = {"tested": "intersection_tested", "visited": "intersection_visited", "steps": "traversal_steps",
            **{name: f"memory_{name}" for name in COUNTS[3:]}}
# Streams between the ports and a unit.
_MEMORY = ("o_request", "i_reply", "o_bus", "i_bus")
# The tables of the memory system.
_TABLES = ("cells", "lists", "types", "geometry")


def cluster_members(config: Config) -> dict[str, wiring.Member]:
    """The members of a `Cluster`."""
    formats, path, control, job, memory = (
        kind(config) for kind in (IcuFormats, PathFormats, ControlFormats, JobFormats, MemoryFormats))
    return {
        "number": In(path.cluster), "reset": In(1), "i_word": In(stream.Signature(control.load_word)),
        "loads": Out(1), "scene": In(path.scene), "i_job": In(stream.Signature(job.word, always_ready=True)),
        "requests": Out(1), "begins": Out(1), "cycle": In(32), "o_end": Out(stream.Signature(WORD_BITS)),
        "o_write": Out(stream.Signature(memory.request(0))), "o_write_data": Out(stream.Signature(memory.write_data)),
        "i_written": In(stream.Signature(memory.written(0), always_ready=True)),
        "o_request": Out(stream.Signature(path.remote_request)),
        "i_reply": In(stream.Signature(formats.patch_vertex)), "i_remote": In(stream.Signature(path.remote_request)),
        "o_remote": Out(stream.Signature(path.remote_reply)), "o_bus": Out(stream.Signature(path.request)),
        "i_bus": In(stream.Signature(path.bus_reply, always_ready=True)),
        "fault": Out(control.fault), "counter": In(COUNTER_BITS), "count": Out(32)}


class Cluster(wiring.Component):
    """Casts sections of frusta one after the other. While it casts one, it receives the next one and writes the results
    of the one before.

    ::

        i_job - FrustumSlot - SectionCast - SectionResults - o_end
                                                   |
        i_word -+- FrustumLoad - tables       ResultWriter - o_write
                '- TableLoad -.                    |
        TraversalUnit - MemorySystem - IntersectionUnit
              |                               |
              '------- settle map ------------'

    Patches whose windows are subshells are in the cluster's own memory; traversal requests them like other clusters do.
    Without lists of subshells (``ctu.subshell_bits`` of 0) nothing is built for them.

    Parameters
    ----------
    config
        The configuration; ``noc`` has the number of clusters.

    Members
    -------
    number : In(PathFormats.cluster)
        The number of this cluster and of its node. Stable after reset.
    reset : In(1)
        Resets everything but the tables.
    i_word : In, stream of `ControlFormats.load_word`
        Words of all clusters. Not during a cast.
    loads : Out(1)
        A word has not been stored yet.
    scene : In(PathFormats.scene)
        Numbers of the scene. Stable after the load.
    i_job : In, stream of `JobFormats.word`
        Words of sections for all clusters. Always ready.
    requests : Out(1)
        A request for one more section, for one cycle each.
    begins : Out(1)
        A section begins to be cast.
    cycle : In(32)
        The engine's cycle counter.
    o_end : Out, stream of 64 bits
        Of each section the words of its completion record, see `SectionResults`.
    o_write : Out, stream of `MemoryFormats.request`
        `WriteMerge`'s ``i_request``.
    o_write_data : Out, stream of `MemoryFormats.write_data`
        Its ``i_data``.
    i_written : In, stream of `MemoryFormats.written`
        Its ``o_written``. Always ready.
    o_request : Out, stream of `PathFormats.remote_request`
        Patches of other clusters, see `MemorySystem`.
    i_reply : In, stream of `Formats.patch_vertex`
        Their vertices.
    i_remote : In, stream of `PathFormats.remote_request`
        Requests of other clusters.
    o_remote : Out, stream of `PathFormats.remote_reply`
        Replies to them.
    o_bus : Out, stream of `PathFormats.request`
        Requests on the local bus.
    i_bus : In, stream of `PathFormats.bus_reply`
        Replies. Always ready.
    fault : Out(ControlFormats.fault)
        The first fault of the present section.
    counter : In(COUNTER_BITS)
        The number of one of `COUNTERS`.
    count : Out(32)
        Its value, see `CounterChoice`.

    Timing
    ------
    See the units.

    Golden counterpart: `golden.engine.cast.cluster_casting.ClusterCasting`. Source: Shen 1993, section 5.3.
    """

    def __init__(self, *, config: Config):
        self._config, self._formats = config, CtuFormats(config)
        self._memory = MemorySystem(config=config)
        self._intersection = IntersectionUnit(config=config)
        self._traversal = TraversalUnit(config=config, pipelines=config.ctu.traversal_pipelines(config.noc.clusters))
        super().__init__(cluster_members(config))

    def elaborate(self, platform):
        m = Module()
        memory, intersection, traversal = self._memory, self._intersection, self._traversal
        m.submodules.memory, m.submodules.intersection, m.submodules.traversal = memory, intersection, traversal
        m.submodules.load = load = FrustumLoad(config=self._config)
        m.submodules.slot = slot = FrustumSlot(config=self._config)
        m.submodules.control = control = SectionCast(config=self._config)
        m.submodules.results = results = SectionResults(config=self._config)
        for name in _MEMORY:
            wiring.connect(m, wiring.flipped(getattr(self, name)), getattr(memory, name))
        m.d.comb += [memory.scene.eq(self.scene), memory.cluster.eq(self.number),
                     intersection.patches.eq(self.scene.patches)]
        self._add_load(m, load)
        self._add_begin(m, load, slot, control)
        self._add_cast(m, control)
        self._add_subshells(m, load)
        self._add_results(m, control, results)
        m.d.comb += [
            results.begins.eq(control.begins), results.results.eq(slot.o.payload.results),
            self.begins.eq(control.begins)]
        self._add_ends(m, control, results)
        return ResetInserter(self.reset)(m)

    def _add_load(self, m, load):
        """Words to the tables of all units."""
        memory, intersection, traversal = self._memory, self._intersection, self._traversal
        m.submodules.words = words = SkidBuffer(self.i_word.payload.shape())
        m.submodules.tables = tables = TableLoad(config=self._config)
        m.submodules.entries = entries = SkidBuffer(load.o_table.payload.shape())
        wiring.connect(m, wiring.flipped(self.i_word), words.i)
        wiring.connect(m, load.o_table, entries.i)
        given, mine = words.o.payload, Signal()
        sends = [getattr(tables, f"o_{name}").valid for name in _TABLES]
        m.d.comb += [
            self.loads.eq(words.o.valid | entries.o.valid | load.o_grid.valid | Cat(sends).any()),
            mine.eq(given.is_all | (given.cluster == self.number)),
            load.i.valid.eq(words.o.valid & mine), load.i.payload.eq(given.item),
            words.o.ready.eq(load.i.ready),
            memory.reloads.eq(words.o.valid & (given.item.region == RegionNumber.PATCHES)),
            tables.i.valid.eq(words.o.valid & mine & load.i.ready), tables.i.payload.eq(given.item)]
        for name in _TABLES:
            wiring.connect(m, getattr(tables, f"o_{name}"), getattr(memory, f"i_load_{name}"))
        wiring.connect(m, load.o_grid, traversal.i_table)
        table, ours = entries.o, intersection.i_table
        wiring.connect(m, table, ours)
        if self._config.ctu.subshells:
            m.d.comb += [traversal.i_slack.valid.eq(table.valid & ours.ready),
                         traversal.i_slack.payload.eq(table.payload)]

    def _add_begin(self, m, load, slot, control):
        """The section, its frustum and the near cells."""
        memory, intersection, traversal = self._memory, self._intersection, self._traversal
        word, given, numbers = slot.i, slot.o.payload, slot.o.payload.numbers
        m.d.comb += [
            word.valid.eq(self.i_job.valid & (self.i_job.payload.cluster == self.number)),
            word.payload.eq(self.i_job.payload),
            slot.free.eq(control.free), self.requests.eq(slot.requests),
            control.i.valid.eq(slot.o.valid), control.i.payload.eq(given.section), slot.o.ready.eq(control.i.ready)]
        frustum = Signal(self._formats.frustum)
        m.d.comb += [
            *(frustum[name].eq(numbers[name]) for name in frustum.shape().members if name in numbers.shape().members),
            frustum.section.eq(given.section), frustum.tiles_across.eq(control.tiles_across)]
        wiring.connect(m, control.o_memory, memory.i_start)
        m.submodules.near = near = NearCellBanks(config=self._config)
        wiring.connect(m, slot.o_near, near.i_load)
        wiring.connect(m, near.o, traversal.i_near)
        if self._config.icu.shadow_bits:
            m.submodules.rays = rays = RayList(config=self._config)
            wiring.connect(m, slot.o_ray, rays.i_load)
            wiring.connect(m, rays.o, intersection.i_ray)
            m.d.comb += [rays.frustum.eq(frustum), rays.i.payload.eq(given.rays),
                         rays.i.valid.eq(control.begins & frustum.is_shadow)]
            claim(m, ~rays.i.valid | rays.i.ready, "the rays of the section before have left")
        traversal_frustum = traversal.i_frustum.payload
        m.d.comb += [
            intersection.i_frustum.valid.eq(control.o_intersection.valid), intersection.i_frustum.payload.eq(frustum),
            control.o_intersection.ready.eq(intersection.i_frustum.ready),
            near.i.valid.eq(control.o_near.valid), near.i.payload.bank.eq(given.bank),
            near.i.payload["count"].eq(given.near_cells), control.o_near.ready.eq(near.i.ready),
            traversal.i_frustum.valid.eq(control.o_traversal.valid),
            control.o_traversal.ready.eq(traversal.i_frustum.ready), traversal_frustum.traversal.frustum.eq(frustum),
            *(traversal_frustum.traversal[name].eq(numbers[name]) for name in ("to_global", "grid_origin")),
            traversal_frustum.traversal.cells.eq(load.cells),
            traversal_frustum.last_shell.eq(given.last_shell), traversal_frustum.subshells.first.eq(0),
            traversal_frustum.subshells["count"].eq(load.subshells),
            traversal_frustum.subshells.patches.eq(self.scene.patches)]

    def _add_cast(self, m, control):
        """Cells, patches, the settle map."""
        memory, intersection, traversal = self._memory, self._intersection, self._traversal
        # Registered: no combinational path from the memory system's queue to the traversal.
        opened = traversal.o
        m.submodules.cells = cells = SkidBuffer(self._formats.cell)
        wiring.connect(m, cells.o, memory.i_cell)
        m.d.comb += [
            cells.i.valid.eq(opened.valid & ~opened.payload.final), cells.i.payload.eq(opened.payload.cell),
            opened.ready.eq(cells.i.ready),
            control.ends.eq(opened.valid & opened.ready & opened.payload.final),
            control.closed.eq(traversal.closed), control.drained.eq(memory.drained & ~cells.o.valid),
            # A patch does not say which stage it is for: all stages wait for all patches.
            traversal.settled.eq(control.idle)]
        # Registered: no combinational path from the intersection unit to the memory system.
        m.submodules.merged = merged = SkidBuffer(memory.o_vertex.payload.shape())
        wiring.connect(m, memory.o_vertex, merged.i)
        wiring.connect(m, merged.o, intersection.i_vertex)
        vertex, moves = Signal(2), Signal()
        m.d.comb += [
            moves.eq(merged.i.valid & merged.i.ready), control.enters.eq(moves & (vertex == 0)),
            intersection.o_done.ready.eq(1), control.leaves.eq(intersection.o_done.valid)]
        with m.If(moves):
            m.d.sync += vertex.eq(vertex + 1)
        wiring.connect(m, traversal.o_tile, intersection.i_settle)
        wiring.connect(m, intersection.o_settle, traversal.i_word)

    def _add_subshells(self, m, load):
        """The list, and its patches beside those that other clusters request."""
        memory, traversal = self._memory, self._traversal
        if not self._config.ctu.subshells:
            wiring.connect(m, wiring.flipped(self.i_remote), memory.i_remote)
            wiring.connect(m, memory.o_remote, wiring.flipped(self.o_remote))
            return
        m.submodules.list = table = SubshellTable(config=self._config)
        wiring.connect(m, load.o_subshell, table.i_load)
        wiring.connect(m, traversal.o_entry, table.i)
        wiring.connect(m, table.o, traversal.i_entry)
        m.submodules.remote = remote = Arbiter(self.i_remote.payload.shape(), count=2)
        m.submodules.vertices = vertices = Queue(traversal.i_vertex.payload.shape(), depth=VERTICES)
        others, mine, answer = remote.i[0], remote.i[1], memory.o_remote
        wiring.connect(m, wiring.flipped(self.i_remote), others)
        m.d.comb += [
            mine.valid.eq(traversal.o_patch.valid), traversal.o_patch.ready.eq(mine.ready),
            mine.payload.node.eq(self.number), mine.payload.patch.eq(traversal.o_patch.payload),
            memory.i_remote.valid.eq(remote.o.valid), remote.o.ready.eq(memory.i_remote.ready),
            memory.i_remote.payload.eq(remote.o.payload.item)]
        # No other cluster requests under this number.
        is_mine = Signal()
        m.d.comb += [
            is_mine.eq(answer.payload.node == self.number), vertices.i.valid.eq(answer.valid & is_mine),
            vertices.i.payload.eq(answer.payload.vertex), self.o_remote.valid.eq(answer.valid & ~is_mine),
            self.o_remote.payload.eq(answer.payload),
            answer.ready.eq(Mux(is_mine, vertices.i.ready, self.o_remote.ready))]
        wiring.connect(m, vertices.o, traversal.i_vertex)

    def _add_results(self, m, control, results):
        """Hits and sums of a section to main memory."""
        intersection = self._intersection
        m.submodules.writer = writer = ResultWriter(config=self._config)
        wiring.connect(m, control.o_results, results.i)
        wiring.connect(m, results.o_read_out, intersection.i_read_out)
        wiring.connect(m, results.o_command, writer.i)
        wiring.connect(m, writer.o_done, results.i_done)
        wiring.connect(m, intersection.o_hit, writer.i_hit)
        wiring.connect(m, intersection.o_sum, writer.i_sum)
        wiring.connect(m, writer.o_request, wiring.flipped(self.o_write))
        wiring.connect(m, writer.o_data, wiring.flipped(self.o_write_data))
        wiring.connect(m, wiring.flipped(self.i_written), writer.i_written)
        wiring.connect(m, results.o, wiring.flipped(self.o_end))

    def _add_ends(self, m, control, results):
        """The first fault of a section; counters."""
        memory, traversal = self._memory, self._traversal
        m.submodules.faults = faults = ClusterFaults(config=self._config)
        m.d.comb += [
            faults.memory.eq(memory.fault), faults.ends.eq(control.ends), faults.error.eq(traversal.error),
            faults.clear.eq(results.clear), memory.clear.eq(results.clear), self.fault.eq(faults.fault),
            results.fault.eq(faults.fault), results.cycle.eq(self.cycle), results.cycles.eq(control.cycles)]
        groups = (1, *map(len, UNIT_COUNTERS.values()))
        m.submodules.choice = choice = CounterChoice(groups=groups, number_bits=COUNTER_BITS)
        units = {"intersection": self._intersection, "traversal": traversal, "memory": memory}
        counts = {"cycles": control.cycles} | {
            f"{unit}_{name}": units[unit].counters[name] for unit, names in UNIT_COUNTERS.items() for name in names}
        m.d.comb += [*(results.counts[name].eq(counts[counter]) for name, counter in RECORDED.items()),
                     choice.counter.eq(self.counter), self.count.eq(choice.count),
                     *(choice.counts[number].eq(counts[name]) for number, name in enumerate(COUNTERS))]
