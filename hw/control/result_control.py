"""Result control: hits of one cluster after the other, then the sums of all."""

from amaranth.hdl import Array, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.control.control_formats import ControlFormats
from hw.icu.icu_formats import IcuFormats
from hw.memsys.fault import Fault
from hw.memsys.memory_formats import MemoryFormats
from hw.memsys.path_formats import PathFormats
from hw.memsys.result_formats import ResultFormats, ResultKind

__all__ = ["ResultControl"]


class ResultControl(wiring.Component):
    """Issues the commands of the write DMA, and reads out the clusters: the hits of each, then the sums of all.

    After a fault all clusters are still read out, so that the next frustum begins with sums of 0.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of ``hits``, ``sums``, ``earlier``
        What is written, and whether of the frustum before the present one. Accepted when the previous results have been
        written.
    busy : Out(1)
        Results are being written.
    results : In(ControlFormats.results)
        Of that frustum. Stable while ``busy``.
    sections : In(ArrayLayout(Formats.section, nodes))
        The clusters' sections of that frustum, likewise.
    total : In(IcuFormats.weight_sum)
        The sum of all its weights, likewise.
    o_read_out : Out, stream of ``earlier``
        ``i_read_out`` of the cluster of number ``cluster``.
    i_hit : In, stream of ``last``
        A hit of that cluster is transferred. Always ready.
    cluster : Out(PathFormats.cluster)
        The cluster that is read out.
    drops : Out(1)
        Its hits are discarded.
    o_sums : Out, stream of the last patch id
        ``i_sums`` of all clusters.
    o_command : Out, stream of `ResultFormats.command`
        `WriteDma`'s ``i``.
    i_done : In, stream of `MemoryFormats.fault`
        Its ``o_done``.
    o_over : Out, stream of `MemoryFormats.fault`
        One for each ``i``. Always ready.

    Timing
    ------
    Latency: ``1`` cycle to the first read-out.
    """

    latency = 1

    def __init__(self, *, config: Config):
        self._config, memory, control = config, MemoryFormats(config), ControlFormats(config)
        formats = IcuFormats(config)
        super().__init__({
            "i": In(stream.Signature(StructLayout({"hits": 1, "sums": 1, "earlier": 1}))), "busy": Out(1),
            "results": In(control.results), "sections": In(ArrayLayout(formats.section, config.noc.nodes)),
            "total": In(formats.weight_sum), "o_read_out": Out(stream.Signature(1)),
            "i_hit": In(stream.Signature(1, always_ready=True)), "cluster": Out(PathFormats(config).cluster),
            "drops": Out(1), "o_sums": Out(stream.Signature(config.icu.patch_bits + 1)),
            "o_command": Out(stream.Signature(ResultFormats(config).command)),
            "i_done": In(stream.Signature(memory.fault)),
            "o_over": Out(stream.Signature(memory.fault, always_ready=True))})

    def elaborate(self, platform):
        m = Module()
        given, is_sums, results = Signal.like(self.i.payload), Signal(), self.results
        fault, command = Signal.like(self.i_done.payload), self.o_command.payload
        sections = Array(self.sections[k].as_value() for k in range(self._config.noc.nodes))
        m.d.comb += [
            command.kind.eq(Mux(is_sums, ResultKind.SUMS, ResultKind.HITS)),
            command.address.eq(Mux(is_sums, results.sums.address, results.hits.address)),
            command["count"].eq(Mux(is_sums, results.sums["count"], results.hits["count"])),
            command.columns.eq(results.columns), command.section.eq(sections[self.cluster]),
            command.total.eq(self.total),
            self.o_read_out.payload.eq(given.earlier), self.o_sums.payload.eq(results.sums["count"] - 1),
            self.o_over.payload.eq(fault), self.busy.eq(1)]
        with m.FSM():
            with m.State("Wait"):
                m.d.comb += [self.i.ready.eq(1), self.busy.eq(0)]
                m.d.sync += [given.eq(self.i.payload), is_sums.eq(0), self.cluster.eq(0), fault.code.eq(Fault.NONE)]
                with m.If(self.i.valid):
                    m.next = "Read out"
            with m.State("Read out"):
                m.d.comb += self.o_read_out.valid.eq(1)
                with m.If(self.o_read_out.ready):
                    m.next = "Command"
                    with m.If(~given.hits):
                        m.next = "Drop"
            with m.State("Drop"):
                m.d.comb += self.drops.eq(1)
                with m.If(self.i_hit.valid & self.i_hit.payload):
                    m.next = "Next"
            with m.State("Command"):
                m.d.comb += self.o_command.valid.eq(1)
                with m.If(self.o_command.ready):
                    m.next = "Write"
            with m.State("Write"):
                m.d.comb += self.i_done.ready.eq(1)
                with m.If(self.i_done.valid):
                    with m.If(fault.code == Fault.NONE):
                        m.d.sync += fault.eq(self.i_done.payload)
                    m.next = "Next"
            with m.State("Next"):
                m.d.sync += self.cluster.eq(self.cluster + 1)
                m.next = "Read out"
                with m.If(is_sums | (self.cluster == self._config.noc.nodes - 1)):
                    m.next = "Sums"
            with m.State("Sums"):
                m.d.sync += [is_sums.eq(1), self.cluster.eq(0)]
                m.next = "Request the sums"
                with m.If(is_sums | ~given.sums):
                    m.d.comb += self.o_over.valid.eq(1)
                    m.next = "Wait"
            with m.State("Request the sums"):
                m.d.comb += self.o_sums.valid.eq(1)
                with m.If(self.o_sums.ready):
                    m.next = "Command"
        return m
