"""Job records: completion records that no cluster writes."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from golden.engine.jobs.completion import NO_CLUSTER
from hw.control.job_formats import JobFormats
from hw.registers.error_code import ErrorCode

__all__ = ["JobRecords"]


class JobRecords(wiring.Component):
    """Records of loads that are over, of descriptors that are refused, and of all that a reset has ended.

    While the queue runs a load's record comes before those of refusals. After a reset the sections are aborted cluster
    by cluster, the oldest first, then the load. One of them is the culprit: it has its code, all others
    `ErrorCode.ABORTED`.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    live, stops, aborts : In(1)
        The queue runs or drains; the units are in reset; what was in flight is to be aborted.
    blames : In(1)
        ``culprit`` is what causes a reset, or nothing of what is in flight is.
    culprit : In(JobFormats.culprit)
        `ClusterWatch`'s.
    tag : In(32)
        Of the oldest section of ``cluster``.
    count, begun : In(JobFormats.in_flight)
        Its sections, and how many of them have begun.
    load : In(JobFormats.record)
        `LoadState`'s ``record``.
    has_load, load_over : In(1)
        Its ``busy`` and ``is_over``.
    i : In, stream of `JobFormats.record`
        Records of refusals.
    o : Out, stream of `JobFormats.record`
        All records.
    cluster : Out(range(clusters + 1))
        The cluster whose sections are aborted; ``clusters``: it is the load's turn.
    pops : Out(1)
        The oldest section of ``cluster`` is aborted.
    load_ends, refuses : Out(1)
        The record of the load, of a refusal, is accepted.
    aborted : Out(1)
        Nothing is in flight any more.

    Timing
    ------
    Latency: ``0`` cycles. One record per cycle, with a gap of a cycle between clusters; stalls with ``o``.
    """

    latency = 0

    def __init__(self, *, config: Config):
        self._clusters, formats = config.noc.clusters, JobFormats(config)
        self._culprit, records = formats.culprit, stream.Signature(formats.record)
        super().__init__({
            "live": In(1), "stops": In(1), "aborts": In(1), "blames": In(1), "culprit": In(formats.culprit),
            "tag": In(32), "count": In(formats.in_flight), "begun": In(formats.in_flight), "load": In(formats.record),
            "has_load": In(1), "load_over": In(1), "i": In(records), "o": Out(records),
            "cluster": Out(range(self._clusters + 1)),
            **{name: Out(1) for name in ("pops", "load_ends", "refuses", "aborted")}})

    def elaborate(self, platform):
        m = Module()
        record, culprit, taken, blamed = self.o.payload, Signal(self._culprit), Signal(), Signal()
        at_load = self.cluster == self._clusters
        has_culprit = culprit.code != ErrorCode.NONE
        m.d.comb += [taken.eq(self.o.valid & self.o.ready), self.pops.eq(self.aborts & ~at_load & taken)]
        with m.If(self.live & self.load_over):
            m.d.comb += [self.o.valid.eq(1), record.eq(self.load), self.load_ends.eq(taken)]
        with m.Elif(self.live):
            m.d.comb += [self.o.valid.eq(self.i.valid), record.eq(self.i.payload), self.i.ready.eq(self.o.ready),
                         self.refuses.eq(taken)]
        with m.Elif(self.aborts & at_load):
            m.d.comb += [self.o.valid.eq(self.has_load), self.load_ends.eq(taken), self.aborted.eq(~self.has_load)]
            with m.If(self.load_over):
                m.d.comb += record.eq(self.load)
            with m.Else():
                m.d.comb += [record.tag.eq(self.load.tag), record.cluster.eq(NO_CLUSTER), record.code.eq(
                    Mux(has_culprit & culprit.is_load, culprit.code, ErrorCode.ABORTED))]
        with m.Elif(self.aborts):
            m.d.comb += [
                blamed.eq(has_culprit & ~culprit.is_load & (culprit.cluster == self.cluster)
                          & (~culprit.newest | (self.begun == 1))),
                self.o.valid.eq(self.count != 0), record.tag.eq(self.tag), record.cluster.eq(self.cluster),
                record.code.eq(Mux(blamed, culprit.code, ErrorCode.ABORTED)),
                record.number.eq(Mux(blamed, culprit.number, 0))]
            with m.If(self.count == 0):
                m.d.sync += self.cluster.eq(self.cluster + 1)
            with m.If(taken & blamed):
                m.d.sync += culprit.code.eq(ErrorCode.NONE)
        with m.If(self.stops):
            m.d.sync += self.cluster.eq(0)
        with m.If(self.blames):
            m.d.sync += culprit.eq(self.culprit)
        return m
