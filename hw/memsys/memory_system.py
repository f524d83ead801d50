"""Memory system of a cluster: from the cells of its traversal to the vertices of every patch in them, once."""

from dataclasses import dataclass

from amaranth.hdl import Cat, Const, Module, Mux, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.formats import Formats
from hw.lib.arbiter import Arbiter
from hw.lib.checks import claim
from hw.lib.first_fault import FirstFault
from hw.lib.queue import Queue
from hw.lib.skid_buffer import SkidBuffer
from hw.lib.start_all import StartAll
from hw.memsys.patches.cell_table import CellTable
from hw.memsys.patches.filter import Filter
from hw.memsys.patches.local_bus_interface import LocalBusInterface
from hw.memsys.patches.local_patch_geometry import LocalPatchGeometry
from hw.memsys.patches.patch_merge import PatchMerge
from hw.memsys.patches.patch_store import PatchStore
from hw.memsys.patches.patch_table import PatchTable
from hw.memsys.patches.patch_type_memory import PatchTypeMemory
from hw.memsys.patches.path_fault import PathFault
from hw.memsys.patches.path_formats import PathFormats
from hw.memsys.patches.vertex_merge import VertexMerge
from hw.memsys.patches.void_check import VoidCheck
from hw.memsys.patches.work_count import WorkCount
from hw.memsys.port.timeout import Timeout

__all__ = ["COUNTERS", "MemorySystem"]

# Since the beginning of the frustum, the last three since reset, with what each one counts.
COUNTERS = {
    "seen": "cells from the traversal", "opened": "cells opened, each once", "named": "entries of their patch lists",
    "found": "patches found, each once", "own": "patches from the cluster's own memory",
    "kept": "patches from the patch store, without a fetch", "remote": "patches from other clusters",
    "hits": "patches from the cache", "misses": "patches from main memory",
    "answered": "patches sent to other clusters",
    "deferred": "requests that waited in the patch store for a fetch",
    "stalls": "cycles in which a vertex stalled at the intersection unit"}

# Capacities: of the queues before the filters, for cells and for patches, and of those before each source of patches.
CELL_QUEUE, PATCH_QUEUE, REQUEST_QUEUE = 16, 32, 4
# Cells, and patches, in flight at most: in the queues, in the filters, and requested.
MOST = 1023
# Of the last merge: the own memory, then others, or what the store has kept and what it has not.
SOURCES = 3
LOADS = {"cells": "cell_load", "lists": "list_load", "types": "type_load", "geometry": "geometry_load"}


class MemorySystem(wiring.Component):
    """Opens each cell once per frustum and outputs each patch in it once, from the nearest memory that has it: the
    cluster's own, another cluster's, or the bus. With ``memsys.store_patches`` a patch store is in front of the latter
    two.

    ::

        i_cell - queue - cell filter - CellTable -+- PatchTable -+- queue - patch filter - PatchTypeMemory -+- own
                                                  '-- bus -------'                                          |- remote
                                                                      o_vertex <- VertexMerge --------------+- bus
                                     i_remote - PatchTypeMemory - LocalPatchGeometry - o_remote

    With a patch store::

        PatchTypeMemory -+- own - VertexMerge - o_vertex
                         '- PatchStore -+- remote -.
                                        '- bus ----'- PatchMerge - PatchStore - VertexMerge

    A faulty cell or patch is flagged and dropped; the others are not delayed. A patch that is not in the memory named
    for it is flagged by the cluster that requests it, and leaves with vertices of 0, which no ray hits. The store is
    emptied after each load of cells, residence or patches, of whatever node.

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
    reloads : In(1)
        A node loads patches, this one or another one. Likewise.
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
        The first fault, or a time-out that has come after it, until it is cleared.
    clear : In(1)
        Clears it.
    counters : Out(COUNTERS)
        The counters.

    Timing
    ------
    Latency: ``35`` cycles from a cell with one patch, in this cluster's memory, to its first vertex. One cell, one
    entry of a list and one vertex per cycle; stalls with ``o_vertex`` and with its replies. Patches that others hold
    take what `PatchStore` states, if there is one.

    Golden counterpart: `golden.engine.memsys`. Source: Shen 1993, section 5.3.6.
    """

    latency = 35

    def __init__(self, *, config: Config):
        self._config, self._formats = config, PathFormats(config)
        formats, icu = self._formats, Formats(config)
        self._icu, request = icu, stream.Signature(formats.remote_request)
        super().__init__({
            **{f"i_load_{name}": In(stream.Signature(getattr(formats, load), always_ready=True))
               for name, load in LOADS.items()},
            "reloads": In(1), "scene": In(formats.scene), "cluster": In(formats.cluster),
            "i_start": In(stream.Signature(0)),
            "i_cell": In(stream.Signature(icu.cell)), "o_vertex": Out(stream.Signature(icu.patch_vertex)),
            "o_request": Out(request), "i_reply": In(stream.Signature(icu.patch_vertex)), "i_remote": In(request),
            "o_remote": Out(stream.Signature(formats.remote_reply)),
            "o_bus": Out(stream.Signature(formats.request)),
            "i_bus": In(stream.Signature(formats.bus_reply, always_ready=True)),
            "drained": Out(1), "fault": Out(formats.fault), "clear": In(1),
            "counters": Out(StructLayout(dict.fromkeys(COUNTERS, 32)))})

    def elaborate(self, platform):
        m = Module()
        config, memsys, formats, icu = self._config, self._config.memsys, self._formats, self._icu
        filters = {"generation_bits": memsys.filter_generation_bits}
        m.submodules.cell_queue = cell_queue = Queue(icu.cell, depth=CELL_QUEUE)
        m.submodules.cell_filter = cell_filter = Filter(bits=icu.cell.width, count=memsys.scene_cells, **filters)
        m.submodules.cell_table = cell_table = CellTable(config=config)
        m.submodules.patch_table = patch_table = PatchTable(config=config)
        m.submodules.patch_queue = patch_queue = Queue(formats.listed_bits, depth=PATCH_QUEUE)
        m.submodules.patch_filter = patch_filter = Filter(
            bits=formats.listed_bits, count=1 << icu.patch.width, **filters)
        m.submodules.types = types = PatchTypeMemory(config=config)
        m.submodules.geometry = geometry = LocalPatchGeometry(config=config)
        m.submodules.merge = merge = VertexMerge(config=config, count=SOURCES)
        m.submodules.bus = bus = LocalBusInterface(config=config)
        m.submodules.cells = cells = WorkCount(enters=1, leaves=4, most=MOST)
        m.submodules.patches = patches = WorkCount(enters=1, leaves=3 + (2 if memsys.store_patches else 1), most=MOST)

        # Tables.
        for load, table in ((self.i_load_cells, cell_table), (self.i_load_lists, patch_table),
                            (self.i_load_types, types), (self.i_load_geometry, geometry)):
            wiring.connect(m, wiring.flipped(load), table.i_load)
        m.d.comb += [
            cell_table.lists.eq(self.scene.lists), patch_table.patches.eq(self.scene.patches),
            cell_filter.limit.eq(self.scene.cells), patch_filter.limit.eq(self.scene.patches),
            geometry.cluster.eq(self.cluster), types.cluster.eq(self.cluster),
            self.drained.eq(cells.empty & patches.empty)]
        # Cells, through the filter and the table to their lists, here or on the bus.
        m.d.comb += [
            cell_queue.i.payload.eq(self.i_cell.payload),
            cell_queue.i.valid.eq(self.i_cell.valid & ~self.i_start.valid),
            self.i_cell.ready.eq(cell_queue.i.ready & ~self.i_start.valid)]
        wiring.connect(m, cell_queue.o, cell_filter.i)
        wiring.connect(m, cell_filter.o, cell_table.i)
        # Registered, here and after the type memory: no combinational path from the source of a patch to a filter.
        m.submodules.cell_found = cell_found = SkidBuffer(cell_table.o.payload.shape())
        wiring.connect(m, cell_table.o, cell_found.i)
        no_list = self._route_cells(m, cell_found.o, patch_table.i, bus.i_cell)

        # Entries of both kinds of lists, to the patch queue.
        listed, own_ends, bus_ends = self._merge_lists(m, patch_table.o, bus.o_listed, patch_queue.i)
        wiring.connect(m, patch_queue.o, patch_filter.i)

        # Patches, from the filter to the nearest source, and the vertices from there.
        wiring.connect(m, patch_filter.o, types.i)
        m.submodules.patch_found = patch_found = SkidBuffer(types.o.payload.shape())
        wiring.connect(m, types.o, patch_found.i)
        no_source, fetched = self._route_patches(m, patch_found.o, geometry.i)
        wiring.connect(m, geometry.o, merge.i[0])
        wiring.connect(m, merge.o, wiring.flipped(self.o_vertex))
        others = self._add_store(m, fetched, bus, merge) if memsys.store_patches else self._add_fetches(
            m, fetched, bus, merge)
        self._add_start(m, ((cell_filter.i_start, 1), (patch_filter.i_start, 1), *others.starts))
        wiring.connect(m, bus.o_request, wiring.flipped(self.o_bus))
        wiring.connect(m, wiring.flipped(self.i_bus), bus.i_reply)
        begins = self.i_start.valid & self.i_start.ready
        claim(m, ~begins | ~Cat(others.taken, *(gate.level for gate in bus.gates)).any(), "all entries are free")

        # A cell leaves with its last entry, which counts as a patch from then on.
        m.d.comb += [cells.enters.eq(self.i_cell.valid & self.i_cell.ready), patches.enters.eq(listed)]
        for count, ends in ((cells, (cell_filter.dropped, no_list, own_ends, bus_ends)),
                            (patches, (patch_filter.dropped, no_source, *others.lost, merge.left.any()))):
            m.d.comb += [leaves.eq(end) for leaves, end in zip(count.leaves, ends, strict=True)]

        # Requests of other clusters, and of subshells under the own number.
        wiring.connect(m, wiring.flipped(self.i_remote), types.i_remote)
        wiring.connect(m, types.o_remote, geometry.i_remote)
        # Requesters see a register of whether replies are taken, not the network.
        m.submodules.replies = replies = SkidBuffer(self.o_remote.payload.shape(), bypass=True)
        wiring.connect(m, geometry.o_remote, replies.i)
        wiring.connect(m, replies.o, wiring.flipped(self.o_remote))

        m.submodules.timeout = timeout = Timeout(bits=config.memory.timeout_bits + 2)
        vertex, cell, patch = self.o_vertex, cell_found.o, patch_found.o
        reply, answer = self.i_reply, self.o_remote
        voids = [self._add_check(m, "reply", reply.payload, reply.valid & reply.ready)]
        if config.ctu.subshells:
            voids.append(self._add_check(m, "subshell", answer.payload.vertex, answer.valid & answer.ready
                                         & (answer.payload.node == self.cluster)))
        # A stall of the intersection unit is no time-out.
        m.d.sync += [
            timeout.waits.eq(~self.drained & ~(vertex.valid & ~vertex.ready)),
            timeout.moves.eq(vertex.valid | self.i_bus.valid | (self.i_reply.valid & self.i_reply.ready)
                             | patches.enters.any() | patches.leaves.any() | cells.leaves.any())]
        self._add_fault(m, (
            *((void, PathFault.RESIDENCE, number) for void, number in voids),
            (geometry.wrong, PathFault.RESIDENCE, geometry.number),
            (bus.lost_patch, PathFault.BUS, bus.patch), (bus.lost_cell, PathFault.BUS, bus.cell),
            (no_source, PathFault.RESIDENCE, patch.payload.patch),
            (patch_filter.wrong, PathFault.PATCH, patch_filter.number),
            (cell.valid & cell.payload.wrong, PathFault.LIST, cell.payload.cell),
            (cell_filter.wrong, PathFault.CELL, cell_filter.number),
            (timeout.expired, PathFault.TIMEOUT, 0)))
        m.d.comb += [self.counters.seen.eq(cell_filter.seen), self.counters.opened.eq(cell_filter.passed),
                     self.counters.named.eq(patch_filter.seen), self.counters.found.eq(patch_filter.passed)]
        m.d.comb += self.counters.deferred.eq(others.deferred)
        self._add_counters(m, own=merge.left[0], remote=others.remote,
                           totals={"hits": bus.hits, "misses": bus.misses, "kept": others.hits})
        return m

    def _add_start(self, m, units):
        """A frustum's beginning: all units that hold something of before empty at the same time."""
        m.submodules.start = start = StartAll(count=len(units))
        m.d.comb += [start.i.valid.eq(self.i_start.valid & self.drained), self.i_start.ready.eq(start.i.ready),
                     start.which.eq(Cat(is_old for _, is_old in units))]
        for output, (unit, _) in zip(start.o, units, strict=True):
            wiring.connect(m, output, unit)

    @staticmethod
    def _route_cells(m, found, own, bus):
        """Each cell to its list, in the own memory or on the bus; returns that a cell leaves that has none."""
        cell, nothing = found.payload, found.payload.wrong | found.payload.is_empty
        no_list = Signal()
        m.d.comb += [
            own.payload.eq(cell.list), own.valid.eq(found.valid & ~nothing & cell.is_own),
            bus.payload.eq(cell.cell), bus.valid.eq(found.valid & ~nothing & ~cell.is_own),
            found.ready.eq(nothing | Mux(cell.is_own, own.ready, bus.ready)), no_list.eq(found.valid & nothing)]
        return no_list

    def _merge_lists(self, m, own_entries, bus_entries, merged):
        """Entries of both kinds of lists to one stream; returns how many enter it, and of both whether a list ends."""
        m.submodules.lists = lists = Arbiter(self._formats.listed_bits, count=2)
        # Registered: no combinational path from the grant to tables, filters and the bus interface.
        m.submodules.own_listed = own = SkidBuffer(own_entries.payload.shape())
        m.submodules.bus_listed = bus = SkidBuffer(bus_entries.payload.shape())
        wiring.connect(m, own_entries, own.i)
        wiring.connect(m, bus_entries, bus.i)
        # An entry without an id only marks the end of the list.
        is_id = bus.o.payload.item.is_id
        m.d.comb += [
            lists.i[0].valid.eq(own.o.valid), lists.i[0].payload.eq(own.o.payload.number),
            own.o.ready.eq(lists.i[0].ready),
            lists.i[1].valid.eq(bus.o.valid & is_id), lists.i[1].payload.eq(bus.o.payload.item.number),
            bus.o.ready.eq(lists.i[1].ready | ~is_id),
            merged.valid.eq(lists.o.valid), lists.o.ready.eq(merged.ready), merged.payload.eq(lists.o.payload.item)]
        return (sum(one.valid & one.ready for one in lists.i),
                *(one.valid & one.ready & one.payload.last for one in (own.o, bus.o)))

    def _route_patches(self, m, found, own):
        """Each patch to the own memory, or to the stream of those that others hold; returns that a patch leaves that
        has no source, and that stream.
        """
        patch, lost = found.payload, Signal()
        m.submodules.own_patches = own_queue = Queue(own.payload.shape(), depth=REQUEST_QUEUE)
        fetched = stream.Signature(self._formats.store_request).create(path=("fetched",))
        is_here = patch.is_held & (patch.cluster == self.cluster)
        m.d.comb += [
            own_queue.i.payload.patch.eq(patch.patch), own_queue.i.payload.address.eq(patch.address),
            own_queue.i.valid.eq(found.valid & is_here & ~patch.wrong), fetched.payload.patch.eq(patch.patch),
            fetched.payload.node.eq(patch.cluster), fetched.payload.is_remote.eq(patch.is_held),
            fetched.valid.eq(found.valid & ~is_here & ~patch.wrong), lost.eq(found.valid & patch.wrong),
            found.ready.eq(patch.wrong | Mux(is_here, own_queue.i.ready, fetched.ready))]
        wiring.connect(m, own_queue.o, own)
        return lost, fetched

    def _route_fetches(self, m, fetched, bus):
        """Requests for patches that others hold, to the network and to the bus."""
        m.submodules.remote_patches = remote = Queue(self.o_request.payload.shape(), depth=REQUEST_QUEUE)
        m.submodules.bus_patches = local = Queue(self._icu.patch, depth=REQUEST_QUEUE)
        patch = fetched.payload
        m.d.comb += [
            remote.i.payload.node.eq(patch.node), remote.i.payload.patch.eq(patch.patch),
            local.i.payload.eq(patch.patch), remote.i.valid.eq(fetched.valid & patch.is_remote),
            local.i.valid.eq(fetched.valid & ~patch.is_remote),
            fetched.ready.eq(Mux(patch.is_remote, remote.i.ready, local.i.ready))]
        wiring.connect(m, remote.o, wiring.flipped(self.o_request))
        wiring.connect(m, local.o, bus.i_patch)

    def _add_fetches(self, m, fetched, bus, merge):
        """Patches that others hold, without a store."""
        self._route_fetches(m, fetched, bus)
        wiring.connect(m, wiring.flipped(self.i_reply), merge.i[1])
        wiring.connect(m, bus.o_vertex, merge.i[2])
        return _Others(starts=(), lost=(bus.lost_patch,), remote=merge.left[1], hits=Const(0, 32),
                       deferred=Const(0, 32), taken=Const(0, 1))

    def _add_store(self, m, fetched, bus, merge):
        """Patches that others hold, through the patch store."""
        memsys = self._config.memsys
        m.submodules.store = store = PatchStore(config=self._config, frames=memsys.store_patches,
                                                requests=memsys.store_requests)
        m.submodules.fills = fills = PatchMerge(config=self._config, count=2)
        # Patches whose fetch has failed, between others.
        m.submodules.lost_patches = lost = Queue(self._icu.patch, depth=memsys.store_requests)
        wiring.connect(m, fetched, store.i)
        self._route_fetches(m, store.o_fetch, bus)
        wiring.connect(m, wiring.flipped(self.i_reply), fills.i[0])
        wiring.connect(m, bus.o_vertex, fills.i[1])
        wiring.connect(m, fills.o, store.i_fill)
        wiring.connect(m, lost.o, store.i_lost)
        wiring.connect(m, store.o_stored, merge.i[1])
        wiring.connect(m, store.o_passed, merge.i[2])
        is_old = Signal(init=1)
        m.d.comb += [lost.i.valid.eq(bus.lost_patch), lost.i.payload.eq(bus.patch)]
        with m.If(store.i_start.valid & store.i_start.ready):
            m.d.sync += is_old.eq(0)
        with m.If(self.i_load_cells.valid | self.i_load_types.valid | self.reloads):
            m.d.sync += is_old.eq(1)
        return _Others(starts=((store.i_start, is_old),), lost=tuple(store.lost), remote=fills.left[0], hits=store.hits,
                       deferred=store.deferred, taken=store.taken)

    def _add_check(self, m, name, vertex, moves):
        """Whether a patch has come from a memory that does not hold it, and which one; a cycle later."""
        m.submodules[f"{name}_check"] = check = VoidCheck(config=self._config)
        void, number = Signal(name=f"{name}_void"), Signal.like(vertex.patch, name=f"{name}_number")
        m.d.comb += [check.vertex.eq(vertex.vertex), check.moves.eq(moves)]
        m.d.sync += [void.eq(check.void), number.eq(vertex.patch)]
        return void, number

    def _add_fault(self, m, causes):
        """The first fault, or a time-out; of several in one cycle the last of ``causes``: whether, its code and its
        number.
        """
        m.submodules.first_fault = first_fault = FirstFault(layout=self.fault.shape(), count=1,
                                                            urgent=PathFault.TIMEOUT.value)
        # Registered: the causes are far from each other. A fault is known before the results of the section are due.
        found = Signal.like(self.fault)
        m.d.sync += found.code.eq(PathFault.NONE)
        for k, (happens, what, which) in enumerate(causes):
            happened, number = Signal(name=f"happened_{k}"), Signal.like(found.number, name=f"number_{k}")
            m.d.sync += [happened.eq(happens), number.eq(which)]
            with m.If(happened):
                m.d.sync += [found.code.eq(what), found.number.eq(number)]
        m.d.comb += [first_fault.i[0].valid.eq(found.code != PathFault.NONE), first_fault.i[0].payload.eq(found),
                     first_fault.clear.eq(self.clear), self.fault.eq(first_fault.o)]

    def _add_counters(self, m, *, own, remote, totals):
        """Counters of a frustum; ``totals`` are since reset, ``own`` and ``remote`` are patches that leave."""
        vertex, count = self.o_vertex, self.counters
        before = {name: Signal(32, name=f"{name}_before") for name in totals}
        m.d.comb += [count[name].eq(total - before[name]) for name, total in totals.items()]
        for name, happens in (("own", own), ("remote", remote), ("stalls", vertex.valid & ~vertex.ready),
                              ("answered", self.i_remote.valid & self.i_remote.ready)):
            # Registered: the events are far away.
            happened = Signal(name=f"counts_{name}")
            m.d.sync += [happened.eq(happens), count[name].eq(count[name] + happened)]
        with m.If(self.i_start.valid & self.i_start.ready):
            m.d.sync += [count.own.eq(0), count.remote.eq(0),
                         *(before[name].eq(total) for name, total in totals.items())]


@dataclass(frozen=True, kw_only=True, eq=False)
class _Others:
    """What the memory system knows of the patches that others hold.

    Parameters
    ----------
    starts
        Units that begin with a frustum, and whether they do with the next one.
    lost
        Bits: a patch leaves without vertices.
    remote
        A patch of another cluster has come, or leaves.
    hits, deferred
        Patches from the store without a fetch, and requests that have waited in it, since reset.
    taken
        Entries of the store in flight.
    """

    starts: tuple
    lost: tuple
    remote: Value
    hits: Value
    deferred: Value
    taken: Value
