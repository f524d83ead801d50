"""Load control: the shared tables, then those of each cluster; or the same tables for all."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from golden.engine.jobs.load_regions import LOADED_REGIONS
from golden.engine.memory_map import ALIGNMENT
from hw.control.control_formats import ControlFormats
from hw.control.job_formats import JobFormats
from hw.memsys.load.preload_dma import OWN
from hw.memsys.patches.path_formats import PathFormats
from hw.memsys.port.fault import Fault
from hw.memsys.port.memory_formats import MemoryFormats

__all__ = ["ALL", "LoadControl"]

# Regions that must be loaded before a cast.
ALL = LOADED_REGIONS


class LoadControl(wiring.Component):
    """Issues the commands of the preload DMA, and addresses its words.

    With ``copies`` one command reads all regions, and all clusters get the tables of cluster 0. Otherwise the first
    command reads the regions that all clusters share, and a further one for each cluster reads its own part of the
    regions `OWN`.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `JobFormats.load`
        Loads; the image is at an address that is a multiple of 64, or there is none. Accepted when the previous load
        has ended.
    busy : Out(1)
        Tables are being read.
    o_command : Out, stream of `MemoryFormats.preload`
        `PreloadDma`'s ``i``.
    i_done : In, stream of `MemoryFormats.fault`
        Its ``o_done``.
    i_word : In, stream of `MemoryFormats.table_word`
        Its ``o``.
    o_word : Out, stream of `ControlFormats.load_word`
        The words for the clusters.
    stored : In(1)
        All words of ``o_word`` are in the tables of the clusters. 0 from the cycle after a transfer on, until they are.
    o_over : Out, stream of `MemoryFormats.fault`
        One for each load. Always ready. After a fault the other regions have not been read.

    Timing
    ------
    Latency: ``1`` cycle to the first command, ``0`` of a word. One word per cycle; stalls with ``o_word``.
    """

    latency = 1

    def __init__(self, *, config: Config):
        self._config, memory = config, MemoryFormats(config)
        control = ControlFormats(config)
        self._cluster = PathFormats(config).cluster
        super().__init__({
            "i": In(stream.Signature(JobFormats(config).load)),
            "busy": Out(1),
            "o_command": Out(stream.Signature(memory.preload)),
            "i_done": In(stream.Signature(memory.fault)),
            "i_word": In(stream.Signature(memory.table_word)),
            "o_word": Out(stream.Signature(control.load_word)), "stored": In(1),
            "o_over": Out(stream.Signature(memory.fault, always_ready=True))})

    def elaborate(self, platform):
        m = Module()
        given, is_all, cluster = Signal.like(self.i.payload), Signal(), Signal(self._cluster)
        regions, command = Signal.like(given.regions), self.o_command.payload
        m.d.comb += [
            regions.eq(given.regions & Mux(given.copies, -1, Mux(is_all, ~OWN, OWN))), command.image.eq(given.image),
            command.cluster.eq(cluster), command.regions.eq(regions),
            self.o_word.valid.eq(self.i_word.valid), self.i_word.ready.eq(self.o_word.ready),
            self.o_word.payload.item.eq(self.i_word.payload),
            self.o_word.payload.cluster.eq(cluster), self.o_word.payload.is_all.eq(is_all)]
        fault, wrong = Signal.like(self.i_done.payload), Signal()
        m.d.comb += wrong.eq((given.image[:ALIGNMENT.bit_length() - 1] != 0) | given.image[len(command.image):].any())
        m.d.comb += [self.o_over.payload.eq(fault), self.busy.eq(1)]
        with m.FSM():
            with m.State("Wait"):
                m.d.comb += [self.i.ready.eq(1), self.busy.eq(0)]
                m.d.sync += [given.eq(self.i.payload), is_all.eq(1), cluster.eq(0)]
                with m.If(self.i.valid):
                    m.next = "Command"
            with m.State("Command"):
                m.d.comb += self.o_command.valid.eq(~wrong)
                with m.If(wrong):
                    m.d.sync += [fault.code.eq(Fault.IMAGE), fault.address.eq(given.image)]
                    m.next = "Next"
                with m.Elif(self.o_command.ready):
                    m.next = "Read"
            with m.State("Read"):
                m.d.comb += self.i_done.ready.eq(1)
                with m.If(self.i_done.valid):
                    m.d.sync += fault.eq(self.i_done.payload)
                    m.next = "Store"
            with m.State("Store"), m.If(self.stored):
                m.next = "Next"
            with m.State("Next"):
                m.d.sync += is_all.eq(0)
                with m.If(~is_all):
                    m.d.sync += cluster.eq(cluster + 1)
                m.next = "Command"
                with m.If((fault.code != Fault.NONE) | ((given.regions & OWN) == 0) | given.copies
                          | (~is_all & (cluster == self._config.noc.nodes - 1))):
                    m.d.comb += self.o_over.valid.eq(1)
                    m.next = "Wait"
        return m
