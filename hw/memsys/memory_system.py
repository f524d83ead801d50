"""Memory system of a cluster: from the cells of its traversal to the vertices of every patch in them, once."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.formats import Formats
from hw.lib.arbiter import Arbiter
from hw.lib.queue import Queue
from hw.lib.skid_buffer import SkidBuffer
from hw.memsys.cell_table import CellTable
from hw.memsys.filter import Filter
from hw.memsys.local_bus_interface import LocalBusInterface
from hw.memsys.local_patch_geometry import LocalPatchGeometry
from hw.memsys.patch_table import PatchTable
from hw.memsys.patch_type_memory import PatchTypeMemory
from hw.memsys.path_fault import PathFault
from hw.memsys.path_formats import PathFormats
from hw.memsys.timeout import Timeout
from hw.memsys.vertex_merge import VertexMerge
from hw.memsys.work_count import WorkCount

__all__ = ["COUNTERS", "MemorySystem"]

# Since the beginning of the frustum, the last two since reset, with what each one counts.
COUNTERS = {
    "seen": "cells from the traversal", "opened": "cells opened, each once", "named": "entries of their patch lists",
    "found": "patches found, each once", "own": "patches from the cluster's own memory",
    "remote": "patches from other clusters", "hits": "patches from the cache", "misses": "patches from main memory",
    "answered": "patches sent to other clusters", "stalls": "cycles in which a vertex stalled at the intersection unit"}

# Capacities: of the queues before the filters, for cells and for patches, and of those before each source of patches.
CELL_QUEUE, PATCH_QUEUE, REQUEST_QUEUE = 16, 32, 4
# Cells, and patches, in flight at most: in the queues, in the filters, and requested.
MOST = 1023
LOADS = {"cells": "cell_load", "lists": "list_load", "types": "type_load", "geometry": "geometry_load"}


class MemorySystem(wiring.Component):
    """Opens each cell once per frustum and outputs each patch in it once, from the nearest memory that has it: the
    cluster's own, another cluster's, or the bus.

    ::

        i_cell - queue - cell filter - CellTable -+- PatchTable -+- queue - patch filter - PatchTypeMemory -+- own
                                                  '-- bus -------'                                          |- remote
                                                                      o_vertex <- VertexMerge --------------+- bus
                                     i_remote - PatchTypeMemory - LocalPatchGeometry - o_remote

    A faulty cell or patch is flagged and dropped; the others are not delayed.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i_load_cells : In, stream of `PathFormats.cell_load`
        Always ready; not while cells or patches are in flight, here or at clusters that request from this one.
    i_load_lists : In, stream of `PathFormats.list_load`
        Likewise.
    i_load_types : In, stream of `PathFormats.type_load`
        Likewise.
    i_load_geometry : In, stream of `PathFormats.geometry_load`
        Likewise.
    scene : In(PathFormats.scene)
        Numbers of the scene. Stable after the load.
    cluster : In(PathFormats.cluster)
        The number of this cluster, which is that of its node in the network, and names it in residence tables. Stable.
    i_start : In, stream without payload
        Begins a frustum; accepted when the memory system is ``drained``.
    i_cell : In, stream of `Formats.cell`
        Cells in the order of the traversal.
    o_vertex : Out, stream of `Formats.patch_vertex`
        Four vertices of a patch, one after the other, to the intersection unit.
    o_request : Out, stream of `PathFormats.remote_request`
        The network interface's ``i_request``.
    i_reply : In, stream of `Formats.patch_vertex`
        Its ``o_reply``.
    i_remote : In, stream of `PathFormats.remote_request`
        Its ``o_request``.
    o_remote : Out, stream of `PathFormats.remote_reply`
        Its ``i_reply``.
    o_bus : Out, stream of `PathFormats.request`
        The local bus' ``i_request``.
    i_bus : In, stream of `PathFormats.bus_reply`
        Its ``o_reply`` of this cluster. Always ready.
    drained : Out(1)
        All cells have been opened, and all vertices of all patches in them have left.
    fault : Out(PathFormats.fault)
        The first fault, until it is cleared.
    clear : In(1)
        Clears it.
    counters : Out(COUNTERS)
        The counters.

    Timing
    ------
    Latency: ``35`` cycles from a cell with one patch, in this cluster's memory, to its first vertex. One cell, one
    entry of a list and one vertex per cycle; stalls with ``o_vertex`` and with its replies.

    Golden counterpart: `golden.memsys`. Source: Shen 1993, section 5.3.6.
    """

    latency = 35

    def __init__(self, *, config: Config):
        self._config, self._formats = config, PathFormats(config)
        formats, icu = self._formats, Formats(config)
        self._icu, request = icu, stream.Signature(formats.remote_request)
        super().__init__({
            **{f"i_load_{name}": In(stream.Signature(getattr(formats, load), always_ready=True))
               for name, load in LOADS.items()},
            "scene": In(formats.scene), "cluster": In(formats.cluster), "i_start": In(stream.Signature(0)),
            "i_cell": In(stream.Signature(icu.cell)), "o_vertex": Out(stream.Signature(icu.patch_vertex)),
            "o_request": Out(request), "i_reply": In(stream.Signature(icu.patch_vertex)), "i_remote": In(request),
            "o_remote": Out(stream.Signature(formats.remote_reply)),
            "o_bus": Out(stream.Signature(formats.request)),
            "i_bus": In(stream.Signature(formats.bus_reply, always_ready=True)),
            "drained": Out(1), "fault": Out(formats.fault), "clear": In(1),
            "counters": Out(StructLayout(dict.fromkeys(COUNTERS, 32)))})

    def elaborate(self, platform):
        m = Module()
        config, memsys = self._config, self._config.memsys
        filters = {"generation_bits": memsys.filter_generation_bits}
        m.submodules.cell_queue = self._cell_queue = Queue(self._icu.cell, depth=CELL_QUEUE)
        m.submodules.cell_filter = self._cell_filter = Filter(
            bits=self._icu.cell.width, count=memsys.scene_cells, **filters)
        m.submodules.cell_table = self._cell_table = CellTable(config=config)
        m.submodules.patch_table = self._patch_table = PatchTable(config=config)
        m.submodules.patch_queue = self._patch_queue = Queue(self._formats.listed_bits, depth=PATCH_QUEUE)
        m.submodules.patch_filter = self._patch_filter = Filter(
            bits=self._formats.listed_bits, count=1 << self._icu.patch.width, **filters)
        m.submodules.types = self._types = PatchTypeMemory(config=config)
        m.submodules.geometry = self._geometry = LocalPatchGeometry(config=config)
        m.submodules.merge = self._merge = VertexMerge(config=config, count=3)
        m.submodules.bus = self._bus = LocalBusInterface(config=config)
        m.submodules.cells = self._cells = WorkCount(enters=1, leaves=4, most=MOST)
        m.submodules.patches = self._patches = WorkCount(enters=1, leaves=4, most=MOST)
        self._add_start(m)
        self._add_cells(m)
        self._add_lists(m)
        self._add_patches(m)
        self._add_remote(m)
        self._add_ends(m)
        return m

    def _add_start(self, m):
        """Tables, and a frustum's beginning: both filters empty at the same time."""
        for load, table in ((self.i_load_cells, self._cell_table), (self.i_load_lists, self._patch_table),
                            (self.i_load_types, self._types), (self.i_load_geometry, self._geometry)):
            wiring.connect(m, wiring.flipped(load), table.i_load)
        filters = self._cell_filter, self._patch_filter
        m.d.comb += [
            self._cell_table.lists.eq(self.scene.lists), self._patch_table.patches.eq(self.scene.patches),
            self._cell_filter.limit.eq(self.scene.cells), self._patch_filter.limit.eq(self.scene.patches),
            self._geometry.cluster.eq(self.cluster), self.drained.eq(self._cells.empty & self._patches.empty)]
        # Registered: the filters are far from the beginning of a frustum.
        begins, starts = Signal(), Signal(len(filters))
        m.d.comb += self.i_start.ready.eq(begins & ~starts.any())
        m.d.sync += begins.eq(self.i_start.valid & (begins | self.drained) & ~self.i_start.ready)
        for start, one in zip(starts, filters, strict=True):
            m.d.comb += one.i_start.valid.eq(start)
            with m.If(one.i_start.ready):
                m.d.sync += start.eq(0)
        with m.If(self.i_start.valid & self.drained & ~begins):
            m.d.sync += starts.eq(~0)

    def _add_cells(self, m):
        """Through the filter and the table to their lists, here or on the bus."""
        queue, table = self._cell_queue, self._cell_table
        # Registered, here and after the type memory: no combinational path from the source of a patch to a filter.
        m.submodules.cell_found = buffer = SkidBuffer(table.o.payload.shape())
        wiring.connect(m, table.o, buffer.i)
        self._found_cell = out = buffer.o
        m.d.comb += [
            queue.i.payload.eq(self.i_cell.payload), queue.i.valid.eq(self.i_cell.valid & ~self.i_start.valid),
            self.i_cell.ready.eq(queue.i.ready & ~self.i_start.valid)]
        wiring.connect(m, queue.o, self._cell_filter.i)
        wiring.connect(m, self._cell_filter.o, table.i)
        found, lists, cells = out.payload, self._patch_table.i, self._bus.i_cell
        nothing = found.wrong | found.is_empty
        self._no_list = Signal()
        m.d.comb += [
            lists.payload.eq(found.list), lists.valid.eq(out.valid & ~nothing & found.is_own),
            cells.payload.eq(found.cell), cells.valid.eq(out.valid & ~nothing & ~found.is_own),
            out.ready.eq(nothing | Mux(found.is_own, lists.ready, cells.ready)),
            self._no_list.eq(out.valid & nothing)]

    def _add_lists(self, m):
        """Entries of both kinds of lists to the patch queue."""
        m.submodules.lists = lists = Arbiter(self._formats.listed_bits, count=2)
        # Registered: no combinational path from the grant to tables, filters and the bus interface.
        buffers = []
        for name, listed in ("own", self._patch_table.o), ("bus", self._bus.o_listed):
            m.submodules[f"{name}_listed"] = buffer = SkidBuffer(listed.payload.shape())
            wiring.connect(m, listed, buffer.i)
            buffers.append(buffer.o)
        own, bus = buffers
        # An entry without an id only marks the end of the list.
        is_id = bus.payload.item.is_id
        m.d.comb += [
            lists.i[0].valid.eq(own.valid), lists.i[0].payload.eq(own.payload.number), own.ready.eq(lists.i[0].ready),
            lists.i[1].valid.eq(bus.valid & is_id), lists.i[1].payload.eq(bus.payload.item.number),
            bus.ready.eq(lists.i[1].ready | ~is_id)]
        m.d.comb += [
            self._patch_queue.i.valid.eq(lists.o.valid), lists.o.ready.eq(self._patch_queue.i.ready),
            self._patch_queue.i.payload.eq(lists.o.payload.item)]
        wiring.connect(m, self._patch_queue.o, self._patch_filter.i)
        # A cell leaves with its last entry, which counts as a patch from then on.
        m.d.comb += [
            self._cells.enters.eq(self.i_cell.valid & self.i_cell.ready),
            self._cells.leaves[0].eq(self._cell_filter.dropped), self._cells.leaves[1].eq(self._no_list),
            self._cells.leaves[2].eq(own.valid & own.ready & own.payload.last),
            self._cells.leaves[3].eq(bus.valid & bus.ready & bus.payload.last)]
        m.d.comb += self._patches.enters.eq(sum(one.valid & one.ready for one in lists.i))

    def _add_patches(self, m):
        """From the filter to the nearest source, and the vertices from there."""
        wiring.connect(m, self._patch_filter.o, self._types.i)
        m.submodules.patch_found = buffer = SkidBuffer(self._types.o.payload.shape())
        wiring.connect(m, self._types.o, buffer.i)
        self._found_patch = out = buffer.o
        found = out.payload
        own, remote, bus = sources = [Queue(shape, depth=REQUEST_QUEUE) for shape in (
            self._geometry.i.payload.shape(), self.o_request.payload.shape(), self._icu.patch)]
        for name, queue in zip(("own", "remote", "bus"), sources, strict=True):
            m.submodules[f"{name}_patches"] = queue
        is_here = found.is_held & (found.cluster == self.cluster)
        chosen = Signal(3)
        m.d.comb += [
            chosen.eq(Mux(found.wrong, 0, Mux(is_here, 0b001, Mux(found.is_held, 0b010, 0b100)))),
            own.i.payload.patch.eq(found.patch), own.i.payload.address.eq(found.address),
            remote.i.payload.node.eq(found.cluster), remote.i.payload.patch.eq(found.patch),
            bus.i.payload.eq(found.patch), out.ready.eq(found.wrong)]
        for source, queue in zip(chosen, sources, strict=True):
            m.d.comb += queue.i.valid.eq(out.valid & source)
            with m.If(source):
                m.d.comb += out.ready.eq(queue.i.ready)
        wiring.connect(m, own.o, self._geometry.i)
        wiring.connect(m, remote.o, wiring.flipped(self.o_request))
        wiring.connect(m, bus.o, self._bus.i_patch)
        merge = self._merge
        wiring.connect(m, self._geometry.o, merge.i[0])
        wiring.connect(m, wiring.flipped(self.i_reply), merge.i[1])
        wiring.connect(m, self._bus.o_vertex, merge.i[2])
        wiring.connect(m, merge.o, wiring.flipped(self.o_vertex))
        wiring.connect(m, self._bus.o_request, wiring.flipped(self.o_bus))
        wiring.connect(m, wiring.flipped(self.i_bus), self._bus.i_reply)
        self._lost = Signal()
        m.d.comb += [
            self._lost.eq(out.valid & found.wrong),
            self._patches.leaves[0].eq(self._patch_filter.dropped), self._patches.leaves[1].eq(self._lost),
            self._patches.leaves[2].eq(self._bus.lost_patch), self._patches.leaves[3].eq(merge.left.any())]

    def _add_remote(self, m):
        """Requests of other clusters."""
        wiring.connect(m, wiring.flipped(self.i_remote), self._types.i_remote)
        wiring.connect(m, self._types.o_remote, self._geometry.i_remote)
        wiring.connect(m, self._geometry.o_remote, wiring.flipped(self.o_remote))

    def _add_ends(self, m):
        """The first fault; counters."""
        m.submodules.timeout = timeout = Timeout(bits=self._config.memory.timeout_bits + 2)
        vertex, count = self.o_vertex, self.counters
        # A stall of the intersection unit is no time-out.
        m.d.sync += [
            timeout.waits.eq(~self.drained & ~(vertex.valid & ~vertex.ready)),
            timeout.moves.eq(vertex.valid | self.i_bus.valid | (self.i_reply.valid & self.i_reply.ready)
                             | self._patches.enters.any() | self._patches.leaves.any() | self._cells.leaves.any())]
        geometry, cells, patches = self._geometry, self._cell_filter, self._patch_filter
        # Registered like ``drained``.
        found = Signal.like(self.fault)
        m.d.sync += [found.code.eq(PathFault.NONE), found.number.eq(cells.number)]
        for happens, what, which in (
                (timeout.expired, PathFault.TIMEOUT, 0),
                (geometry.remote_wrong, PathFault.RESIDENCE, geometry.remote_number),
                (geometry.wrong, PathFault.RESIDENCE, geometry.number),
                (self._bus.lost_cell | self._bus.lost_patch, PathFault.BUS, self._bus.number),
                (self._lost, PathFault.RESIDENCE, self._found_patch.payload.patch),
                (patches.wrong, PathFault.PATCH, patches.number),
                (self._found_cell.valid & self._found_cell.payload.wrong, PathFault.LIST,
                 self._found_cell.payload.cell),
                (cells.wrong, PathFault.CELL, cells.number)):
            with m.If(happens):
                m.d.sync += [found.code.eq(what), found.number.eq(which)]
        with m.If(self.clear):
            m.d.sync += self.fault.as_value().eq(0)
        with m.Elif((self.fault.code == PathFault.NONE) & (found.code != PathFault.NONE)):
            m.d.sync += self.fault.eq(found)
        m.d.comb += [count.seen.eq(cells.seen), count.opened.eq(cells.passed), count.named.eq(patches.seen),
                     count.found.eq(patches.passed)]
        before_hits, before_misses = (Signal(32, name=f"{name}_before") for name in ("hits", "misses"))
        m.d.comb += [count.hits.eq(self._bus.hits - before_hits), count.misses.eq(self._bus.misses - before_misses)]
        for name, happens in (("own", self._merge.left[0]), ("remote", self._merge.left[1]),
                              ("stalls", vertex.valid & ~vertex.ready),
                              ("answered", self.i_remote.valid & self.i_remote.ready)):
            # Registered: the events are far away.
            happened = Signal(name=f"counts_{name}")
            m.d.sync += [happened.eq(happens), count[name].eq(count[name] + happened)]
        with m.If(self.i_start.valid & self.i_start.ready):
            m.d.sync += [count.own.eq(0), count.remote.eq(0), before_hits.eq(self._bus.hits),
                         before_misses.eq(self._bus.misses)]
