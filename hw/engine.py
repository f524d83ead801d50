"""Engine: clusters, their networks and bus, registers, and the port of main memory."""

from collections.abc import Callable
from dataclasses import dataclass

from amaranth.hdl import Array, Module, Mux, ResetInserter, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.cluster import Cluster, ClusterSignature
from hw.control.control_formats import ControlFormats
from hw.control.engine_control import EngineControl
from hw.control.load_control import LoadControl
from hw.control.result_control import ResultControl
from hw.control.sum_merge import SumMerge
from hw.lib.arbiter import Arbiter
from hw.lib.black_box import BlackBox
from hw.lib.fork import Fork
from hw.lib.skid_buffer import SkidBuffer
from hw.memsys.axi_signature import AxiSignature
from hw.memsys.cache_policy import CachePolicy
from hw.memsys.image_layout import RegionNumber
from hw.memsys.local_bus import LocalBus
from hw.memsys.main_memory_port import MainMemoryPort
from hw.memsys.memory_formats import MemoryFormats
from hw.memsys.preload_dma import PreloadDma
from hw.memsys.system_bus_interface import READERS, SystemBusInterface
from hw.memsys.write_dma import WriteDma
from hw.noc.patch_network import PatchNetwork
from hw.registers.axi_lite_signature import AxiLiteSignature
from hw.registers.counter_choice import CounterChoice
from hw.registers.engine_registers import ADDRESS_BITS, COUNTER_BITS, ENGINE_REGISTERS, MAGIC, VERSION
from hw.registers.registers import Registers

__all__ = ["CLUSTER", "Engine"]

# The module of a cluster where clusters are black boxes.
CLUSTER = "radiosity_cluster"
# Of reads of main memory; the last one is the preload DMA's.
TAGS = READERS + 1


@dataclass(frozen=True, kw_only=True)
class _Blocks:
    """The blocks of an engine; ``add`` adds one more that a stop resets."""

    registers: Registers
    control: EngineControl
    port: MainMemoryPort
    preload: PreloadDma
    write: WriteDma
    load: LoadControl
    result: ResultControl
    bus: LocalBus
    interface: SystemBusInterface
    clusters: list[Cluster | BlackBox]
    add: Callable


class Engine(wiring.Component):
    """The machine: casts frusta of scenes in main memory.

    ::

        host - Registers - EngineControl - LoadControl, ResultControl
        axi - MainMemoryPort -+- PreloadDma - words - Cluster ...  - PatchNetwork
                              |- WriteDma - hits, SumMerge - ...
                              '- SystemBusInterface - LocalBus - ...

    Parameters
    ----------
    config
        The configuration; a cluster for each node of ``noc``.
    black_boxes
        Clusters are instances of a separately built module (`hw.package.tops`).
    policies
        Policies of the caches that are built; all by default.

    Members
    -------
    host : In, `AxiLiteSignature`
        The registers of `hw.registers.engine_registers`. From ``COUNTERS_BASE`` on the counters of
        `hw.cluster.COUNTERS` as words, 2^``COUNTER_BITS`` for each cluster.
    axi : Out, `AxiSignature`
        Main memory.

    Timing
    ------
    See the units.

    Golden counterpart: `golden.cast.shelling.Shelling`, `golden.memory_map`. Source: Shen 1993, chapter 5.
    """

    def __init__(self, *, config: Config, black_boxes: bool = False,
                 policies: tuple[CachePolicy, ...] = tuple(CachePolicy)):
        self._config, self._black_boxes, self._policies = config, black_boxes, policies
        super().__init__({"host": In(AxiLiteSignature(address_bits=ADDRESS_BITS)),
                          "axi": Out(AxiSignature(config=config))})

    def elaborate(self, platform):
        m = Module()
        config, nodes = self._config, self._config.noc.nodes
        m.submodules.registers = registers = Registers(ENGINE_REGISTERS, address_bits=ADDRESS_BITS)
        m.submodules.control = control = EngineControl(config=config)
        m.submodules.port = port = MainMemoryPort(config=config, tag=range(TAGS))

        def add(name, component):
            m.submodules[name] = ResetInserter(control.stops)(component)
            return component

        blocks = _Blocks(
            registers=registers, control=control, port=port, add=add, preload=add("preload", PreloadDma(config=config)),
            write=add("write", WriteDma(config=config)), load=add("load", LoadControl(config=config)),
            result=add("result", ResultControl(config=config)), bus=add("bus", LocalBus(config=config, clusters=nodes)),
            interface=add("interface", SystemBusInterface(config=config, policies=self._policies)),
            clusters=[BlackBox(ClusterSignature(config=config).members, name=CLUSTER) if self._black_boxes
                      else Cluster(config=config) for _ in range(nodes)])
        for number, cluster in enumerate(blocks.clusters):
            m.submodules[f"cluster_{number}"] = cluster
            m.d.comb += [cluster.number.eq(number), cluster.reset.eq(control.stops)]
        self._add_reads(m, blocks)
        self._add_writes(m, blocks)
        self._add_load(m, blocks)
        self._add_cast(m, blocks)
        self._add_results(m, blocks)
        self._add_registers(m, blocks)
        self._add_counters(m, blocks)
        return m

    def _add_reads(self, m, blocks):
        """Reads of the caches and of the preload DMA; during a stop replies are discarded."""
        port, preload, interface, stops = blocks.port, blocks.preload, blocks.interface, blocks.control.stops
        reads = blocks.add("reads", Arbiter(MemoryFormats(self._config).request(range(TAGS)), count=2))
        for request, tag, merged in ((interface.o_request, interface.o_request.payload.tag, reads.i[0]),
                                     (preload.o_request, READERS, reads.i[1])):
            m.d.comb += [
                merged.valid.eq(request.valid), request.ready.eq(merged.ready), merged.payload.tag.eq(tag),
                *(merged.payload[name].eq(request.payload[name]) for name in ("address", "length"))]
        m.d.comb += [port.i_read.valid.eq(reads.o.valid & ~stops), reads.o.ready.eq(port.i_read.ready),
                     port.i_read.payload.eq(reads.o.payload.item)]
        beat, is_preload = port.o_read, Signal()
        m.d.comb += [is_preload.eq(beat.payload.tag == READERS),
                     beat.ready.eq(Mux(is_preload, preload.i_reply.ready, interface.i_reply.ready) | stops),
                     interface.i_reply.payload.tag.eq(beat.payload.tag)]
        for reply, mine in (preload.i_reply, is_preload), (interface.i_reply, ~is_preload):
            m.d.comb += [reply.valid.eq(beat.valid & mine & ~stops),
                         *(reply.payload[name].eq(beat.payload[name]) for name in ("data", "last", "error"))]
        wiring.connect(m, port.axi, wiring.flipped(self.axi))

    def _add_writes(self, m, blocks):
        """Writes of the write DMA; during a stop outstanding beats are sent without any byte enabled."""
        port, write, stops = blocks.port, blocks.write, blocks.control.stops
        m.d.comb += [
            port.i_write.valid.eq(write.o_request.valid & ~stops), write.o_request.ready.eq(port.i_write.ready),
            *(port.i_write.payload[name].eq(write.o_request.payload[name]) for name in ("address", "length")),
            port.i_write_data.valid.eq(write.o_data.valid | stops), write.o_data.ready.eq(port.i_write_data.ready),
            port.i_write_data.payload.data.eq(write.o_data.payload.data),
            port.i_write_data.payload.strobe.eq(Mux(stops, 0, write.o_data.payload.strobe)),
            write.i_written.valid.eq(port.o_written.valid & ~stops),
            port.o_written.ready.eq(write.i_written.ready | stops),
            write.i_written.payload.error.eq(port.o_written.payload.error)]

    def _add_load(self, m, blocks):
        """Words to the clusters; numbers and addresses of the scene."""
        registers, control, preload = blocks.registers, blocks.control, blocks.preload
        load, interface, clusters = blocks.load, blocks.interface, blocks.clusters
        wiring.connect(m, load.o_command, preload.i)
        wiring.connect(m, preload.o_done, load.i_done)
        wiring.connect(m, preload.o, load.i_word)
        words = blocks.add("words", Fork(load.o_word.payload.shape(), count=len(clusters)))
        held = blocks.add("held", SkidBuffer(load.o_word.payload.shape()))
        wiring.connect(m, load.o_word, held.i)
        wiring.connect(m, held.o, words.i)
        # Registered: the clusters are far away. Until all have stored it a word keeps one of the terms at 1.
        was_held, was_loading = Signal(), Signal()
        m.d.sync += [was_held.eq(held.o.valid), was_loading.eq(sum(cluster.loads for cluster in clusters).any())]
        m.d.comb += [
            load.stored.eq(~(held.o.valid | was_held | was_loading)),
            load.i.valid.eq(control.loading), load.i.payload.image.eq(registers.image),
            load.i.payload.regions.eq(registers.regions), control.loads.eq(load.busy)]
        scene, takes = interface.scene, Signal()
        tables = {"cells": preload.cells, "lists": preload.patch_lists, "patches": preload.patches}
        with m.If(control.loading):
            m.d.sync += takes.eq(registers.regions[RegionNumber.CELLS.value])
        kept_scene, kept_bases = Signal.like(scene), Signal.like(interface.bases)
        # Known after the header, and stable until the next load of cells.
        with m.If(load.busy & takes):
            m.d.sync += [
                *(kept_scene[name].eq(table["count"]) for name, table in tables.items()),
                *(kept_bases[name].eq(table.address) for name, table in tables.items())]
        m.d.comb += [scene.eq(kept_scene), interface.bases.eq(kept_bases)]
        # The caches are emptied after each load of cells; there is no request before.
        empties = Signal()
        with m.If(load.o_over.valid & takes):
            m.d.sync += empties.eq(1)
        with m.Elif(interface.i_invalidate.ready | control.stops):
            m.d.sync += empties.eq(0)
        m.d.comb += [interface.i_invalidate.valid.eq(empties),
                     interface.i_invalidate.payload.eq(CachePolicy(registers.policy))]
        for cluster, word in zip(clusters, words.o, strict=True):
            wiring.connect(m, word, cluster.i_word)
            m.d.comb += cluster.scene.eq(kept_scene)

    def _add_cast(self, m, blocks):
        """Clusters, bus and network."""
        registers, control = blocks.registers, blocks.control
        bus, interface, clusters = blocks.bus, blocks.interface, blocks.clusters
        wiring.connect(m, bus.o_request, interface.i_request)
        for kind in range(2):
            wiring.connect(m, interface.o_reply[kind], bus.i_reply[kind])
        for number, cluster in enumerate(clusters):
            wiring.connect(m, cluster.o_bus, bus.i_request[number])
            wiring.connect(m, bus.o_reply[number], cluster.i_bus)
            m.d.comb += [cluster.i_cast.valid.eq(control.casting), cluster.clear.eq(control.clear)]
        if len(clusters) == 1:
            # There is no other cluster.
            return
        network = blocks.add("network", PatchNetwork(config=self._config))
        for number, cluster in enumerate(clusters):
            wiring.connect(m, cluster.o_request, network.i_request[number])
            wiring.connect(m, network.o_reply[number], cluster.i_reply)
            wiring.connect(m, network.o_request[number], cluster.i_remote)
            wiring.connect(m, cluster.o_remote, network.i_reply[number])
            m.d.comb += control.networks[number].eq(network.fault[number])
        m.d.comb += [registers.flits.eq(network.flits), registers.flit_stalls.eq(network.stalls)]

    def _add_results(self, m, blocks):
        """Hits of one cluster after the other; sums of all."""
        registers, control, preload = blocks.registers, blocks.control, blocks.preload
        write, result, clusters = blocks.write, blocks.result, blocks.clusters
        formats = ControlFormats(self._config)
        present, before = Signal(formats.results), Signal(formats.results)
        with m.If(control.casting):
            m.d.sync += [before.eq(present), present.columns.eq(preload.columns), present.hits.eq(preload.hits),
                         present.sums.eq(preload.sums)]
        earlier = result.i.payload.earlier
        given, is_earlier = registers.results, Signal()
        m.d.comb += [
            control.earlier.eq(given[2]), result.i.valid.eq(control.writing), result.i.payload.hits.eq(given[0]),
            result.i.payload.sums.eq(given[1]), earlier.eq(given[2]), control.writes.eq(result.busy),
            result.total.eq(registers.total), result.results.eq(Mux(is_earlier, before, present))]
        with m.If(control.writing):
            m.d.sync += is_earlier.eq(earlier)
        hits = blocks.add("hits", SkidBuffer(write.i_hit.payload.shape()))
        requests = blocks.add("sum_requests", Fork(result.o_sums.payload.shape(), count=len(clusters)))
        sums = blocks.add("sums", SumMerge(config=self._config, count=len(clusters)))
        wiring.connect(m, result.o_sums, requests.i)
        wiring.connect(m, sums.o, write.i_sum)
        for number, cluster in enumerate(clusters):
            wiring.connect(m, requests.o[number], cluster.i_sums)
            wiring.connect(m, cluster.o_sum, sums.i[number])
            m.d.comb += [result.sections[number].eq(Mux(is_earlier, cluster.sections[1], cluster.sections[0])),
                         cluster.i_read_out.payload.eq(result.o_read_out.payload)]
            with m.If(result.cluster == number):
                m.d.comb += [
                    cluster.i_read_out.valid.eq(result.o_read_out.valid),
                    result.o_read_out.ready.eq(cluster.i_read_out.ready),
                    hits.i.valid.eq(cluster.o_hit.valid), hits.i.payload.eq(cluster.o_hit.payload),
                    cluster.o_hit.ready.eq(hits.i.ready)]
        hit = hits.o
        m.d.comb += [
            write.i_hit.valid.eq(hit.valid & ~result.drops), write.i_hit.payload.eq(hit.payload),
            hit.ready.eq(write.i_hit.ready | result.drops), result.i_hit.valid.eq(hit.valid & hit.ready),
            result.i_hit.payload.eq(hit.payload.last)]
        command = write.i.payload
        m.d.comb += [
            write.i.valid.eq(result.o_command.valid), result.o_command.ready.eq(write.i.ready),
            *(command[name].eq(result.o_command.payload[name]) for name in command.shape().members)]
        wiring.connect(m, write.o_done, result.i_done)

    def _add_registers(self, m, blocks):
        """Commands and numbers of the host, and what it reads."""
        registers, control, port = blocks.registers, blocks.control, blocks.port
        load, result, interface, clusters = blocks.load, blocks.result, blocks.interface, blocks.clusters
        wiring.connect(m, wiring.flipped(self.host), registers.host)
        m.d.comb += [
            control.i_command.valid.eq(registers.command.valid),
            control.i_command.payload.eq(registers.command.payload),
            control.regions.eq(registers.regions), control.watchdog.eq(registers.watchdog),
            control.memory_busy.eq(port.busy), control.memory_fault.eq(port.fault), port.clear.eq(control.clear),
            control.load_over.valid.eq(load.o_over.valid), control.load_over.payload.eq(load.o_over.payload),
            control.write_over.valid.eq(result.o_over.valid), control.write_over.payload.eq(result.o_over.payload),
            control.casts.eq(sum(cluster.busy for cluster in clusters).any()),
            *(control.clusters[number].eq(cluster.fault) for number, cluster in enumerate(clusters))]
        # A command keeps its windows: the host writes them in several words, and at any time.
        for name, begins in ("read", control.loading | control.casting), ("write", control.writing):
            window = getattr(port, f"{name}_window")
            with m.If(begins):
                m.d.sync += [getattr(window, side).eq(getattr(registers, f"{name}_{side}"))
                             for side in ("base", "limit")]
        m.d.comb += [
            registers.magic.eq(MAGIC), registers.version.eq(VERSION), registers.clusters.eq(len(clusters)),
            registers.status.eq(control.status), registers.error.eq(control.error.code),
            registers.error_cluster.eq(control.error.cluster), registers.error_address.eq(control.error.number),
            *(getattr(registers, f"{kind}_{what}").eq(getattr(interface, f"{kind}_{what}"))
              for kind in ("cell", "patch") for what in ("hits", "misses"))]
        with m.If(control.casting):
            m.d.sync += registers.cycles.eq(0)
        with m.Elif(control.casts):
            m.d.sync += registers.cycles.eq(registers.cycles + 1)

    def _add_counters(self, m, blocks):
        """Counters: all clusters look up the number, one of them replies."""
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
