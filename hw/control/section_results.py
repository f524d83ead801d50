"""Section results: from the end of a cast to the completion of its section."""

from amaranth.hdl import Array, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.control.control_formats import ControlFormats
from hw.control.job_formats import COMPLETION_WORDS, WORD_BITS, JobFormats, elements
from hw.memsys.port.fault import Fault
from hw.memsys.results.result_formats import HitFormat, ResultFormats
from hw.registers.error_code import ErrorCode

__all__ = ["COUNTS", "SectionResults"]

# Fields of a completion record that are counters of the cast.
COUNTS = ("tested", "visited", "steps", "found", "own", "remote", "hits", "misses")


class SectionResults(wiring.Component):
    """Has the hits of a section read out as soon as its cast ends, has the results written, and reports them.

    What the report needs is kept from the slot when the cast begins, and from the units when it ends, so that the next
    section may be cast meanwhile. Of a cast with a fault nothing is written: its hits and sums are dropped.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    begins : In(1)
        `SectionCast.begins`: the section in the slot is being cast from now on.
    results : In(JobFormats.results)
        Of the section in the slot.
    i : In, stream without payload
        `SectionCast.o_results`: a cast has ended.
    cycle : In(32)
        The engine's cycle counter.
    cycles : In(32)
        Cycles of the cast.
    fault : In(ControlFormats.fault)
        The first fault of the cluster's units since it was cleared.
    clear : Out(1)
        Clears it: it has been kept.
    counts : In, struct of `COUNTS`
        Counters of the cast.
    o_read_out : Out, stream without payload
        `IntersectionUnit`'s ``i_read_out``.
    o_command : Out, stream of `ResultFormats.section_command`
        `ResultWriter`'s ``i``.
    i_done : In, stream of `ResultFormats.section_done`
        Its ``o_done``.
    o : Out, stream of 64 bits
        What became of the section: the words of its completion record, without tag, cluster and lap.

    Timing
    ------
    Latency: ``1`` cycle from the read-out to the result command, and from ``i_done`` to ``o``.
    """

    latency = 1

    def __init__(self, *, config: Config):
        control, job, result = ControlFormats(config), JobFormats(config), ResultFormats(config)
        number = control.fault["number"].shape
        self._end = StructLayout({"error": ErrorCode, "address": number, **dict.fromkeys(
            ("sums", "cycles", "begin", "end", *COUNTS), 32)})
        super().__init__({
            "begins": In(1), "results": In(job.results), "i": In(stream.Signature(0)), "cycle": In(32),
            "cycles": In(32),
            "fault": In(control.fault), "clear": Out(1), "counts": In(StructLayout(dict.fromkeys(COUNTS, 32))),
            "o_read_out": Out(stream.Signature(0)), "o_command": Out(stream.Signature(result.section_command)),
            "i_done": In(stream.Signature(result.section_done)), "o": Out(stream.Signature(WORD_BITS))})

    def elaborate(self, platform):
        m = Module()
        present, begin, results = Signal.like(self.results), Signal(32), Signal.like(self.results)
        end, index = Signal(self._end), Signal(range(COMPLETION_WORDS))
        with m.If(self.begins):
            m.d.sync += [present.eq(self.results), begin.eq(self.cycle)]
        m.d.comb += [self.o_command.payload[name].eq(results[name]) for name, _ in results.shape()]
        words = [Signal(WORD_BITS, name=f"word_{k}") for k in range(COMPLETION_WORDS)]
        for name, _ in self._end:
            ((word, bits),) = elements(name, record="completion")
            m.d.comb += words[word][bits].eq(end[name])
        m.d.comb += self.o.payload.eq(Array(words)[index])
        # Of the state that waits the last cycle counts: a register for it alone enables so many.
        waits = Signal(init=1)
        with m.If(waits):
            m.d.sync += [
                results.eq(present), end.begin.eq(begin), end.cycles.eq(self.cycles),
                *(end[name].eq(self.counts[name]) for name in COUNTS), end.error.eq(self.fault.code),
                end.address.eq(self.fault.number)]
            with m.If(self.fault.code != ErrorCode.NONE):
                m.d.sync += [results.hit_format.eq(HitFormat.NONE), results.sums.eq(0)]
        with m.FSM():
            with m.State("Wait"):
                m.d.comb += [self.o_read_out.valid.eq(self.i.valid), self.i.ready.eq(self.o_read_out.ready)]
                with m.If(self.i.valid & self.i.ready):
                    m.d.comb += self.clear.eq(1)
                    m.d.sync += waits.eq(0)
                    m.next = "Command"
            with m.State("Command"):
                m.d.comb += self.o_command.valid.eq(1)
                with m.If(self.o_command.ready):
                    m.next = "Write"
            with m.State("Write"):
                m.d.comb += self.i_done.ready.eq(1)
                done = self.i_done.payload
                with m.If(self.i_done.valid):
                    m.d.sync += [end.sums.eq(Mux(results.sums, done.sums, 0)), end.end.eq(self.cycle)]
                    with m.If((end.error == ErrorCode.NONE) & (done.code != Fault.NONE)):
                        m.d.sync += [end.error.eq(done.code.as_value()), end.address.eq(done.address)]
                    m.next = "Report"
            with m.State("Report"):
                m.d.comb += self.o.valid.eq(1)
                with m.If(self.o.ready):
                    m.d.sync += index.eq(index + 1)
                    with m.If(index == COMPLETION_WORDS - 1):
                        m.d.sync += waits.eq(1)
                        m.next = "Wait"
        return m
