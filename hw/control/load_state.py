"""Load state: the load in flight, of a descriptor or of a resume."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from golden.engine.jobs.completion import NO_CLUSTER
from hw.control.control_formats import ControlFormats
from hw.control.job_formats import JobFormats
from hw.control.load_control import ALL
from hw.memsys.port.fault import Fault
from hw.memsys.port.memory_formats import MemoryFormats
from hw.registers.error_code import ErrorCode

__all__ = ["LoadState"]


class LoadState(wiring.Component):
    """A load is offered, read, and over until its record is written; that of a resume has no record.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `JobFormats.load_job`
        Loads of descriptors; accepted while ``is_open`` and none is in flight.
    is_open : In(1)
        See ``i``.
    resumes : In(1)
        The load of a resume begins: all regions of ``image``, for all clusters those of cluster 0 with ``copies``.
    image : In(64)
        The register.
    copies : In(1)
        See ``resumes``.
    active : In(1)
        A load may be read.
    stops : In(1)
        The load of a resume ends; regions count as loaded no more.
    cycles : In(32)
        The engine's cycle counter.
    read_code : In(ErrorCode)
        What an unsuccessful read of main memory is reported as.
    over : In, stream of `MemoryFormats.fault`
        `LoadControl`'s ``o_over``. Always ready.
    ends : In(1)
        The load's record has been accepted.
    o : Out, stream of `JobFormats.load`
        `LoadControl`'s ``i``.
    record : Out(JobFormats.record)
        Of the load that is over; of one that is not its ``tag`` alone holds.
    busy, reads, is_over : Out(1)
        A load is in flight; it is offered or being read; it waits for its record.
    fault : Out(ControlFormats.fault)
        What the load reports that ends in this cycle.
    succeeds, fails : Out(1)
        A load ends in this cycle without an error; that of a resume ends with one.
    resumed : Out(1)
        The load of a resume ends in this cycle.
    loaded : Out(1)
        All regions have been loaded without an error.

    Timing
    ------
    Latency: ``1`` cycle from ``i`` or ``resumes`` to ``o``. One load in flight.
    """

    latency = 1

    def __init__(self, *, config: Config):
        formats, control = JobFormats(config), ControlFormats(config)
        super().__init__({
            "i": In(stream.Signature(formats.load_job)), "is_open": In(1), "resumes": In(1), "image": In(64),
            "copies": In(1), "active": In(1), "stops": In(1), "cycles": In(32), "read_code": In(ErrorCode),
            "over": In(stream.Signature(MemoryFormats(config).fault, always_ready=True)), "ends": In(1),
            "o": Out(stream.Signature(formats.load)), "record": Out(formats.record), "fault": Out(control.fault),
            **{name: Out(1) for name in ("busy", "reads", "is_over", "succeeds", "fails", "resumed", "loaded")}})

    def elaborate(self, platform):
        m = Module()
        load, record, over = Signal.like(self.o.payload), Signal.like(self.record), Signal()
        is_resume, waits, code = Signal(), Signal(), self.over.payload.code
        m.d.comb += [
            self.o.payload.eq(load), self.record.eq(record), self.record.cluster.eq(NO_CLUSTER), self.busy.eq(1),
            over.eq(self.over.valid & self.active), self.fault.number.eq(self.over.payload.address),
            self.fault.code.eq(Mux(code == Fault.READ_REPLY, self.read_code, code.as_value())),
            self.succeeds.eq(over & (code == Fault.NONE)), self.resumed.eq(over & is_resume),
            self.fails.eq(over & is_resume & (code != Fault.NONE)), self.reads.eq(waits & self.active)]
        with m.If(over):
            m.d.sync += [record.code.eq(self.fault.code), record.number.eq(self.fault.number),
                         record.end.eq(self.cycles),
                         self.loaded.eq((code == Fault.NONE) & (self.loaded | ((load.regions & ALL) == ALL)))]
        with m.If(self.stops):
            m.d.sync += self.loaded.eq(0)

        def moves_on():
            """From the states before the load is over."""
            with m.If(self.ends | (self.stops & is_resume)):
                m.next = "Wait"
            with m.Elif(over):
                m.next = "Over"
                with m.If(is_resume):
                    m.next = "Wait"

        with m.FSM():
            with m.State("Wait"):
                m.d.comb += [self.busy.eq(0), self.i.ready.eq(self.is_open)]
                with m.If(self.i.valid & self.i.ready):
                    m.d.sync += [is_resume.eq(0), record.tag.eq(self.i.payload.tag), record.begin.eq(self.cycles),
                                 *(load[name].eq(self.i.payload[name]) for name, _ in load.shape())]
                    m.next = "Offer"
                with m.Elif(self.resumes):
                    m.d.sync += [is_resume.eq(1), load.image.eq(self.image), load.copies.eq(self.copies),
                                 load.regions.eq((1 << len(load.regions)) - 1)]
                    m.next = "Offer"
            with m.State("Offer"):
                m.d.comb += [waits.eq(1), self.o.valid.eq(self.active)]
                with m.If(self.o.valid & self.o.ready):
                    m.next = "Read"
                moves_on()
            with m.State("Read"):
                m.d.comb += waits.eq(1)
                moves_on()
            with m.State("Over"):
                m.d.comb += self.is_over.eq(1)
                with m.If(self.ends):
                    m.next = "Wait"
        return m
