"""Engine: clusters that cast a queue of sections, their network and bus, registers, and the memory port."""

from types import SimpleNamespace

from amaranth.hdl import Array, Cat, Module, Mux, ResetInserter, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.cluster import Cluster, cluster_members
from hw.control.completion_writer import CompletionWriter
from hw.control.descriptor_fetch import DescriptorFetch
from hw.control.frustum_load import FIRST_SHELL
from hw.control.job_control import JobControl
from hw.control.job_dispatch import JobDispatch
from hw.control.load_control import LoadControl
from hw.lib.arbiter import Arbiter
from hw.lib.black_box import BlackBox
from hw.lib.fork import Fork
from hw.lib.skid_buffer import SkidBuffer
from hw.memsys.bus.cache_policy import CachePolicy
from hw.memsys.bus.local_bus import LocalBus
from hw.memsys.bus.system_bus_interface import READERS, SystemBusInterface
from hw.memsys.load.image_layout import RegionNumber
from hw.memsys.load.preload_dma import PreloadDma
from hw.memsys.patch_node import PatchNode
from hw.memsys.port.axi_signature import AxiSignature
from hw.memsys.port.main_memory_port import MainMemoryPort
from hw.memsys.port.memory_formats import MemoryFormats
from hw.memsys.port.write_merge import WriteMerge
from hw.noc.patch_network import PatchNetwork
from hw.registers.axi_lite_signature import AxiLiteSignature
from hw.registers.counter_choice import CounterChoice
from hw.registers.engine_registers import ADDRESS_BITS, COUNTER_BITS, ENGINE_REGISTERS, MAGIC, VERSION
from hw.registers.registers import Registers

__all__ = ["CLUSTER", "Engine"]

# The module of a cluster where clusters are black boxes.
CLUSTER = "radiosity_cluster"
# Tags of reads of main memory: the caches', the preload DMA's, and the descriptor fetch's.
PRELOAD, FETCH = READERS, READERS + 1
# Registers that `JobControl` reads, and those that it writes, under the same names.
_TO_CONTROL = ("ring", "completions", "ring_bits", "doorbell", "image", "watchdog")
_OF_CONTROL = ("status", "taken", "cycles")


class Engine(wiring.Component):
    """The machine: casts the sections of a ring of descriptors in main memory.

    ::

        host - Registers - JobControl - LoadControl
        axi - MainMemoryPort -+- DescriptorFetch - JobDispatch - words - Cluster ... - PatchNetwork
                              |- PreloadDma - words - ...                   |    |
                              |- SystemBusInterface - LocalBus -------------'    |
                              '- WriteMerge -+- results of each cluster ---------|
                                             '- CompletionWriter ----------------'

    A patch node takes words of loads too, and answers requests of the `PatchNetwork`.

    Parameters
    ----------
    config
        The configuration; a cluster or a patch node for each node of ``noc``.
    black_boxes
        Clusters are instances of a separately built module.
    policies
        Policies of the caches that are built; all by default.

    Members
    -------
    host : In, `AxiLiteSignature`
        The registers of `hw.registers.engine_registers`. From ``COUNTERS_BASE`` on the counters of
        `hw.cluster.COUNTERS` as words, 2^``COUNTER_BITS`` for each cluster.
    axi : Out, `AxiSignature`
        Main memory.
    irq : Out(1)
        A completion record has been written, or the queue has halted, and the register ``interrupt`` enables it.

    Timing
    ------
    See the units.

    Golden counterpart: `golden.engine.jobs.run_job.run_job`. Source: Shen 1993, chapter 5.
    """

    def __init__(self, *, config: Config, black_boxes: bool = False,
                 policies: tuple[CachePolicy, ...] = tuple(CachePolicy)):
        self._config, self._black_boxes, self._policies = config, black_boxes, policies
        super().__init__({"host": In(AxiLiteSignature(address_bits=ADDRESS_BITS)),
                          "axi": Out(AxiSignature(config=config)), "irq": Out(1)})

    def elaborate(self, platform):
        m = Module()
        config, count = self._config, self._config.noc.clusters
        m.submodules.registers = registers = Registers(
            ENGINE_REGISTERS, address_bits=ADDRESS_BITS, memory_bits=self._config.memory.address_bits)
        m.submodules.control = control = JobControl(config=config)
        tags = range(max(FETCH + 1, count + 1))
        m.submodules.port = port = MainMemoryPort(config=config, tag=tags)
        m.submodules.completions = completions = CompletionWriter(config=config)

        def add(name, component):
            """A block that a stop resets."""
            m.submodules[name] = ResetInserter(control.stops)(component)
            return component

        blocks = SimpleNamespace(
            registers=registers, control=control, port=port, completions=completions, add=add,
            fetch=add("fetch", DescriptorFetch(config=config)), dispatch=add("dispatch", JobDispatch(config=config)),
            preload=add("preload", PreloadDma(config=config)), load=add("load", LoadControl(config=config)),
            writes=add("writes", WriteMerge(config=config, count=count + 1)),
            bus=add("bus", LocalBus(config=config, clusters=count)),
            interface=add("interface", SystemBusInterface(config=config, policies=self._policies)),
            clusters=[BlackBox(cluster_members(config), name=CLUSTER) if self._black_boxes
                      else Cluster(config=config) for _ in range(count)],
            patch_nodes=[PatchNode(config=config) for _ in range(config.noc.patch_nodes)])
        for number, patch_node in enumerate(blocks.patch_nodes, start=count):
            m.submodules[f"patch_node_{number}"] = patch_node
            m.d.comb += [patch_node.number.eq(number), patch_node.reset.eq(control.stops)]
        for number, cluster in enumerate(blocks.clusters):
            m.submodules[f"cluster_{number}"] = cluster
            m.d.comb += [cluster.number.eq(number), cluster.reset.eq(control.stops), cluster.cycle.eq(control.cycles)]
        self._add_reads(m, blocks, tags)
        self._add_writes(m, blocks)
        self._add_load(m, blocks)
        self._add_queue(m, blocks)
        self._add_cast(m, blocks)
        self._add_registers(m, blocks)
        self._add_counters(m, blocks)
        return m

    def _add_reads(self, m, blocks, tags):
        """Reads of the caches, the preload DMA and the descriptor fetch; during a stop replies are discarded."""
        port, stops = blocks.port, blocks.control.stops
        readers = ((blocks.interface, None), (blocks.preload, PRELOAD), (blocks.fetch, FETCH))
        reads = blocks.add("reads", Arbiter(MemoryFormats(self._config).request(tags), count=len(readers)))
        beat = port.o_read
        m.d.comb += [port.i_read.valid.eq(reads.o.valid & ~stops), reads.o.ready.eq(port.i_read.ready),
                     port.i_read.payload.eq(reads.o.payload.item), beat.ready.eq(stops)]
        for (reader, tag), merged in zip(readers, reads.i, strict=True):
            request, reply, mine = reader.o_request, reader.i_reply, Signal()
            m.d.comb += [
                merged.valid.eq(request.valid), request.ready.eq(merged.ready),
                merged.payload.tag.eq(request.payload.tag if tag is None else tag),
                *(merged.payload[name].eq(request.payload[name]) for name in ("address", "length")),
                mine.eq(beat.payload.tag < READERS if tag is None else beat.payload.tag == tag),
                reply.valid.eq(beat.valid & mine & ~stops),
                *(reply.payload[name].eq(beat.payload[name]) for name in ("data", "last", "error"))]
            if tag is None:
                # Tags of the others are wider.
                m.d.comb += reply.payload.tag.eq(beat.payload.tag[:len(reply.payload.tag)])
            with m.If(mine & reply.ready):
                m.d.comb += beat.ready.eq(1)
        wiring.connect(m, port.axi, wiring.flipped(self.axi))

    def _add_writes(self, m, blocks):
        """Results and completion records; during a stop outstanding beats are sent without any byte enabled."""
        port, writes, completions, stops = blocks.port, blocks.writes, blocks.completions, blocks.control.stops
        m.d.comb += [
            port.i_write.valid.eq(writes.o_request.valid & ~stops), writes.o_request.ready.eq(port.i_write.ready),
            *(port.i_write.payload[name].eq(writes.o_request.payload[name]) for name in ("address", "length", "tag")),
            port.i_write_data.valid.eq(writes.o_data.valid | stops), writes.o_data.ready.eq(port.i_write_data.ready),
            port.i_write_data.payload.data.eq(writes.o_data.payload.data),
            port.i_write_data.payload.strobe.eq(Mux(stops, 0, writes.o_data.payload.strobe)),
            writes.i_written.valid.eq(port.o_written.valid & ~stops),
            port.o_written.ready.eq(writes.i_written.ready | stops),
            # Tags of reads may be wider.
            writes.i_written.payload.tag.eq(port.o_written.payload.tag[:len(writes.i_written.payload.tag)]),
            writes.i_written.payload.error.eq(port.o_written.payload.error)]
        sources = [(cluster.o_write, cluster.o_write_data, cluster.i_written) for cluster in blocks.clusters]
        sources.append((completions.o_request, completions.o_data, completions.i_written))
        for number, (request, data, written) in enumerate(sources):
            wiring.connect(m, request, writes.i_request[number])
            wiring.connect(m, data, writes.i_data[number])
            wiring.connect(m, writes.o_written[number], written)

    def _add_load(self, m, blocks):
        """Words to the clusters; numbers and addresses of the scene."""
        registers, control, preload = blocks.registers, blocks.control, blocks.preload
        load, interface, clusters = blocks.load, blocks.interface, blocks.clusters
        nodes = [*clusters, *blocks.patch_nodes]
        wiring.connect(m, load.o_command, preload.i)
        wiring.connect(m, preload.o_done, load.i_done)
        wiring.connect(m, preload.o, load.i_word)
        words = blocks.add("words", Fork(load.o_word.payload.shape(), count=len(nodes)))
        held = blocks.add("held", SkidBuffer(load.o_word.payload.shape()))
        wiring.connect(m, load.o_word, held.i)
        wiring.connect(m, held.o, words.i)
        # Registered: nets to the nodes are long. Until all have stored it a word keeps one of the terms at 1.
        was_held, was_loading = Signal(), Signal()
        m.d.sync += [was_held.eq(held.o.valid), was_loading.eq(Cat(node.loads for node in nodes).any())]
        given, begins = control.o_load.payload, Signal()
        m.d.comb += [
            load.stored.eq(~(held.o.valid | was_held | was_loading)), load.i.valid.eq(control.o_load.valid),
            control.o_load.ready.eq(load.i.ready), begins.eq(load.i.valid & load.i.ready),
            *(load.i.payload[name].eq(given[name]) for name, _ in given.shape()),
            control.load_over.valid.eq(load.o_over.valid), control.load_over.payload.eq(load.o_over.payload)]
        scene, takes = interface.scene, Signal()
        tables = {"cells": preload.cells, "lists": preload.patch_lists, "patches": preload.patches}
        takes_shells = Signal()
        with m.If(begins):
            m.d.sync += [takes.eq(given.regions[RegionNumber.CELLS.value]),
                         takes_shells.eq(given.regions[RegionNumber.SHELLS.value])]
        kept_scene, kept_bases = Signal.like(scene), Signal.like(interface.bases)
        with m.If(load.busy & takes_shells):
            m.d.sync += blocks.dispatch.last_shell.eq(preload.shells["count"] + FIRST_SHELL - 1)
        # Known after the header, and stable until the next load of cells.
        with m.If(load.busy & takes):
            m.d.sync += [
                *(kept_scene[name].eq(table["count"][:len(kept_scene[name])]) for name, table in tables.items()),
                *(kept_bases[name].eq(table.address) for name, table in tables.items())]
        m.d.comb += [scene.eq(kept_scene), interface.bases.eq(kept_bases)]
        # The caches are emptied after each load of cells; a request waits for it.
        empties = Signal()
        with m.If(load.o_over.valid & takes):
            m.d.sync += empties.eq(1)
        with m.Elif(interface.i_invalidate.ready | control.stops):
            m.d.sync += empties.eq(0)
        m.d.comb += [interface.i_invalidate.valid.eq(empties),
                     interface.i_invalidate.payload.eq(CachePolicy(registers.policy))]
        for node, word in zip(nodes, words.o, strict=True):
            wiring.connect(m, word, node.i_word)
        m.d.comb += [cluster.scene.eq(kept_scene) for cluster in clusters]

    def _add_queue(self, m, blocks):
        """Descriptors to the clusters, and their completion records."""
        control, fetch, dispatch, completions = blocks.control, blocks.fetch, blocks.dispatch, blocks.completions
        clusters = blocks.clusters
        m.d.comb += [
            fetch.ring.eq(control.kept.ring), fetch.ring_bits.eq(control.kept.ring_bits),
            fetch.doorbell.eq(blocks.registers.doorbell), fetch.taken.eq(control.taken),
            fetch.enable.eq(control.enable), dispatch.enable.eq(control.enable), dispatch.loaded.eq(control.loaded),
            dispatch.requests.eq(Cat(cluster.requests for cluster in clusters)),
            control.begins.eq(Cat(cluster.begins for cluster in clusters)),
            control.unread.eq(dispatch.failed), control.dispatches.eq(dispatch.busy)]
        wiring.connect(m, fetch.o, dispatch.i)
        wiring.connect(m, dispatch.o_sent, control.i_sent)
        wiring.connect(m, dispatch.o_load, control.i_load)
        wiring.connect(m, dispatch.o_refused, control.i_refused)
        for number, cluster in enumerate(clusters):
            m.d.comb += [cluster.i_job.valid.eq(dispatch.o.valid), cluster.i_job.payload.eq(dispatch.o.payload)]
            wiring.connect(m, cluster.o_end, completions.i[number])
        wiring.connect(m, control.o_record, completions.i_record)
        wiring.connect(m, completions.o_collected, control.i_collected)
        m.d.comb += [
            control.source.eq(completions.source), completions.tag.eq(control.tag),
            completions.completions.eq(control.kept.completions), completions.ring_bits.eq(control.kept.ring_bits),
            completions.stops.eq(control.stops), completions.retry.eq(control.retry),
            control.completed.eq(completions.completed), control.empty.eq(completions.empty),
            control.unwritten.eq(completions.failed), control.address.eq(completions.address)]

    def _add_cast(self, m, blocks):
        """Clusters, bus and network."""
        bus, interface, clusters = blocks.bus, blocks.interface, blocks.clusters
        wiring.connect(m, bus.o_request, interface.i_request)
        for kind in range(2):
            wiring.connect(m, interface.o_reply[kind], bus.i_reply[kind])
        for number, cluster in enumerate(clusters):
            wiring.connect(m, cluster.o_bus, bus.i_request[number])
            wiring.connect(m, bus.o_reply[number], cluster.i_bus)
        nodes = [*clusters, *blocks.patch_nodes]
        if len(nodes) == 1:
            # There is no other node.
            return
        network = blocks.add("network", PatchNetwork(config=self._config))
        for number, cluster in enumerate(clusters):
            wiring.connect(m, cluster.o_request, network.i_request[number])
            wiring.connect(m, network.o_reply[number], cluster.i_reply)
        for number, node in enumerate(nodes):
            wiring.connect(m, network.o_request[number], node.i_remote)
            wiring.connect(m, node.o_remote, network.i_reply[number])
            m.d.comb += blocks.control.networks[number].eq(network.fault[number])
        m.d.comb += [blocks.registers.flits.eq(network.flits), blocks.registers.flit_stalls.eq(network.stalls)]

    def _add_registers(self, m, blocks):
        """Commands and numbers of the host, and what it reads."""
        registers, control, port, interface = blocks.registers, blocks.control, blocks.port, blocks.interface
        wiring.connect(m, wiring.flipped(self.host), registers.host)
        for ours, theirs in (registers.command, control.i_command), (registers.interrupt, control.i_interrupt):
            m.d.comb += [theirs.valid.eq(ours.valid), theirs.payload.eq(ours.payload)]
        m.d.comb += [
            *(getattr(control, name).eq(getattr(registers, name)) for name in _TO_CONTROL),
            *(getattr(registers, name).eq(getattr(control, name)) for name in _OF_CONTROL),
            control.memory_busy.eq(port.busy), control.memory_fault.eq(port.fault), port.clear.eq(control.clear),
            *(control.clusters[number].eq(cluster.fault) for number, cluster in enumerate(blocks.clusters)),
            registers.magic.eq(MAGIC), registers.version.eq(VERSION), registers.clusters.eq(len(blocks.clusters)),
            registers.completed.eq(blocks.completions.completed), registers.error.eq(control.error.code),
            registers.error_cluster.eq(control.error.cluster), registers.error_address.eq(control.error.number),
            registers.interrupt_value.eq(control.interrupt_value), self.irq.eq(control.irq),
            *(getattr(registers, f"{kind}_{what}").eq(getattr(interface, f"{kind}_{what}"))
              for kind in ("cell", "patch") for what in ("hits", "misses"))]
        with m.If(control.takes):
            m.d.sync += [getattr(getattr(port, f"{name}_window"), side).eq(getattr(registers, f"{name}_{side}"))
                         for name in ("read", "write") for side in ("base", "limit")]

    def _add_counters(self, m, blocks):
        """Counters: each cluster selects the counter of the number, and the value of one cluster is read."""
        registers, clusters = blocks.registers, blocks.clusters
        counter, waits = Signal.like(registers.o_window.payload), Signal(range(CounterChoice.latency + 2))
        number = counter[COUNTER_BITS:]
        for cluster in clusters:
            m.d.comb += cluster.counter.eq(counter[:COUNTER_BITS])
        m.d.comb += [
            registers.o_window.ready.eq(waits == 0), registers.i_window.valid.eq(waits == 1),
            registers.i_window.payload.eq(Array([
                *(cluster.count for cluster in clusters), 0])[Mux(number >= len(clusters), len(clusters), number)])]
        with m.If(waits > 1):
            m.d.sync += waits.eq(waits - 1)
        with m.Elif((waits == 1) & registers.i_window.ready):
            m.d.sync += waits.eq(0)
        with m.If(registers.o_window.valid & registers.o_window.ready):
            m.d.sync += [counter.eq(registers.o_window.payload), waits.eq(CounterChoice.latency + 1)]
