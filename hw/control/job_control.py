"""Job control: which descriptors are in flight, when the queue halts, and what becomes of them then."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.control.cluster_watch import ClusterWatch
from hw.control.control_formats import ControlFormats
from hw.control.error_register import ErrorRegister
from hw.control.job_formats import JobFormats
from hw.control.job_records import JobRecords
from hw.control.load_state import LoadState
from hw.control.queue_state import QueueState
from hw.control.section_table import SectionTable
from hw.lib.validate import check_instance
from hw.memsys.port.fault import Fault
from hw.memsys.port.memory_formats import MemoryFormats
from hw.noc.network_fault import NetworkFault
from hw.registers.engine_registers import RING_BITS, register
from hw.registers.error_code import ErrorCode

__all__ = ["JobControl"]

# From bit 0 of the register on; the last one is no command, but says what a resume loads.
*_COMMANDS, _ = (field.name for field in register("command").fields)
_COPIES = len(_COMMANDS)
_COUNT_BITS = 32


class JobControl(wiring.Component):
    """Knows the descriptors in flight, halts the queue on an error of the machine, and resumes it.

    ::

        run - ring not readable, doorbell too far - drain - nothing in flight -.
         |- stop, watchdog, PATH_TIMEOUT, NETWORK_*, record not writable ------+- stop - abort - halted - load -.
         '------------------------------------------- resume ---------------------------------------------------'

    In ``stop`` the units are in reset until main memory has no outstanding transaction; events are ignored. In
    ``abort`` each descriptor that was in flight gets a completion record: the one that has caused the reset with its
    code, all others `ErrorCode.ABORTED`. The culprit of a time-out or of a fault of the network is the section which
    the cluster has begun last, that of the watchdog its oldest section, or the load. A ``resume`` loads all regions of
    the image, as the command's ``copies`` says, once records are written and the registers of the ring and the windows
    have been taken over.

    The watchdog of a cluster counts the cycles since its oldest section was sent or the one before was collected, in
    steps of ``nodes``; that of a load its cycles. Of errors of one cycle the first of these is latched: watchdog,
    record, load of a resume, cluster, network, ring, doorbell, command. In the cycle of a clear they come after it.
    What main memory has answered to a load, to the ring or to a record has the code of the port's first fault since the
    last load began, a clear or a stop, whichever access had it, if that is of the same direction; else of a reply.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i_command : In, stream of the register ``command``
        Commands. Always ready.
    i_interrupt : In, stream of the register ``interrupt``
        Writes to it. Always ready.
    ring, completions, image : In(64)
        The registers.
    ring_bits : In(RING_BITS)
        The register.
    doorbell, watchdog : In(32)
        The registers.
    kept : Out, struct of ``ring``, ``completions``, ``ring_bits``
        Those of the ring that have been taken over.
    takes : Out(1)
        They are being taken over, and the windows too: nothing is in flight.
    stops, clear : Out(1)
        Reset all units but the port, the completion writer and this one; clear the port's fault.
    enable, loaded : Out(1)
        The next descriptor may be taken; all regions have been loaded.
    begins : In(clusters)
        A cluster begins to cast the next one of its sections.
    i_sent : In, stream of `JobFormats.sent`
        `JobDispatch`'s ``o_sent``. Always ready.
    i_load : In, stream of `JobFormats.load_job`
        Its ``o_load``; accepted when no section is in flight.
    i_refused : In, stream of `JobFormats.record`
        Its ``o_refused``.
    unread, dispatches : In(1)
        Its ``failed`` and ``busy``.
    o_load : Out, stream of `JobFormats.load`
        `LoadControl`'s ``i``.
    load_over : In, stream of `MemoryFormats.fault`
        Its ``o_over``. Always ready.
    source : In(JobFormats.cluster)
        `CompletionWriter`'s.
    tag : Out(32)
        Of the oldest section of cluster ``source``, while the queue is not halted.
    i_collected : In, stream of a cluster
        Its ``o_collected``. Always ready.
    o_record : Out, stream of `JobFormats.record`
        Its ``i_record``.
    completed : In(32)
        Its.
    empty, unwritten : In(1)
        Its ``empty`` and ``failed``.
    address : In(address_bits)
        Its.
    retry : Out(1)
        Its.
    memory_busy : In(1)
        Main memory has an outstanding transaction.
    memory_fault : In(MemoryFormats.fault)
        The first fault of the port.
    clusters : In(ArrayLayout(ControlFormats.fault, clusters))
        Faults of the clusters; only time-outs have an effect.
    networks : In(ArrayLayout(NetworkFault, nodes))
        Faults of the nodes' network interfaces.
    taken : Out(32)
        The register.
    status : Out(status)
        The register.
    error : Out(ControlFormats.error)
        The first error.
    cycles : Out(32)
        The register.
    interrupt_value : Out(2)
        The register ``interrupt``.
    irq : Out(1)
        The pin.

    Timing
    ------
    Latency: ``1`` cycle from a stop to the reset, at least 2 from a resume to its load. A cluster's fault takes 2 to
    ``nodes + 1`` cycles to the reset. One record, one load in flight; a cluster has at most 3 sections.
    """

    latency = 1

    def __init__(self, *, config: Config):
        check_instance("Config", config, Config)
        self._config, memory, control = config, MemoryFormats(config), ControlFormats(config)
        formats = JobFormats(config)
        clusters, nodes, address = config.noc.clusters, config.noc.nodes, config.memory.address_bits

        def event(layout):
            return In(stream.Signature(layout, always_ready=True))

        super().__init__({
            "i_command": event(register("command").width), "i_interrupt": event(register("interrupt").width),
            **{name: In(64) for name in ("ring", "completions", "image")}, "ring_bits": In(RING_BITS),
            "doorbell": In(_COUNT_BITS), "watchdog": In(_COUNT_BITS),
            "kept": Out(StructLayout({"ring": address, "completions": address, "ring_bits": RING_BITS})),
            **{name: Out(1) for name in ("takes", "stops", "clear", "enable", "loaded")}, "begins": In(clusters),
            "i_sent": event(formats.sent), "i_load": In(stream.Signature(formats.load_job)),
            "i_refused": In(stream.Signature(formats.record)), "unread": In(1), "dispatches": In(1),
            "o_load": Out(stream.Signature(formats.load)), "load_over": event(memory.fault),
            "source": In(formats.cluster), "tag": Out(32), "i_collected": event(formats.cluster),
            "o_record": Out(stream.Signature(formats.record)), "completed": In(_COUNT_BITS), "empty": In(1),
            "unwritten": In(1), "address": In(address), "retry": Out(1), "memory_busy": In(1),
            "memory_fault": In(memory.fault), "clusters": In(ArrayLayout(control.fault, clusters)),
            "networks": In(ArrayLayout(NetworkFault, nodes)), "taken": Out(_COUNT_BITS),
            "status": Out(register("status").width), "error": Out(control.error), "cycles": Out(_COUNT_BITS),
            "interrupt_value": Out(register("interrupt").width), "irq": Out(1)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.state, m.submodules.table = state, table = QueueState(), SectionTable(config=self._config)
        m.submodules.load, m.submodules.records = load, records = (
            LoadState(config=self._config), JobRecords(config=self._config))
        m.submodules.watch, m.submodules.error = watch, error = (
            ClusterWatch(config=self._config), ErrorRegister(config=self._config))
        commands = {name: Signal(name=f"command_{name}") for name in _COMMANDS}
        before = 0
        for k, bit in enumerate(commands.values()):
            m.d.comb += bit.eq(self.i_command.valid & self.i_command.payload[k] & ~before)
            before = self.i_command.payload[:k + 1].any()
        has_section = table.waits.any()
        free = ~(has_section | load.busy | self.dispatches) & self.empty
        self._connect_parts(m, state=state, table=table, load=load, records=records, watch=watch)
        m.d.comb += load.is_open.eq(state.run & ~has_section)
        resets = self._add_errors(m, commands, state=state, load=load, watch=watch, error=error)
        m.d.comb += [
            state.resets.eq(resets), state.drained.eq(free), state.memory_busy.eq(self.memory_busy),
            load.resumes.eq(state.halted & self.takes & state.resuming & ~resets),
            records.blames.eq(state.live & (resets | state.drain))]
        self._add_resume(m, commands, state=state, load=load, free=free)
        self._add_registers(m, state=state, load=load, records=records, free=free)
        return m

    def _connect_parts(self, m, *, state, table, load, records, watch):
        """What the parts tell each other, and the ports that one of them has."""
        for source, target in (
                (wiring.flipped(self.i_sent), table.i_sent), (wiring.flipped(self.i_collected), table.i_collected),
                (wiring.flipped(self.i_load), load.i), (load.o, wiring.flipped(self.o_load)),
                (wiring.flipped(self.load_over), load.over), (wiring.flipped(self.i_refused), records.i),
                (records.o, wiring.flipped(self.o_record))):
            wiring.connect(m, source, target)
        m.d.sync += self.cycles.eq(self.cycles + 1)
        m.d.comb += [
            state.aborted.eq(records.aborted), state.loaded.eq(load.succeeds), state.resumed.eq(load.resumed),
            table.live.eq(state.live), table.begins.eq(self.begins), table.aborts.eq(records.pops),
            table.cluster.eq(Mux(state.abort, records.cluster, self.source)), self.tag.eq(table.tag),
            load.active.eq(~state.stop & ~state.abort), load.stops.eq(state.stop), load.image.eq(self.image),
            load.copies.eq(state.kept_copies), load.cycles.eq(self.cycles), load.ends.eq(records.load_ends),
            self.loaded.eq(load.loaded),
            records.live.eq(state.live), records.stops.eq(state.stop), records.aborts.eq(state.abort),
            records.culprit.eq(watch.culprit), records.tag.eq(table.tag), records.count.eq(table.count),
            records.begun.eq(table.begun), records.load.eq(load.record), records.has_load.eq(load.busy),
            records.load_over.eq(load.is_over),
            watch.live.eq(state.live), watch.stops.eq(state.stop), watch.waits.eq(table.waits),
            watch.restarts.eq(table.restarts), watch.reads.eq(load.reads), watch.watchdog.eq(self.watchdog),
            watch.clusters.eq(self.clusters), watch.networks.eq(self.networks)]

    def _add_errors(self, m, commands, *, state, load, watch, error):
        """Errors of the ring, of records and of commands; returns whether what is in flight ends."""
        code = self.memory_fault.code.as_value()
        is_port = (code != 0) & (code <= Fault.WRITE_PROTOCOL.value)
        unwritten, is_far, resets = Signal(), Signal(), Signal()
        # The port's first fault says why a read or a write failed, if it is of the same direction.
        m.d.comb += [
            load.read_code.eq(Mux(is_port & code[0], code, Fault.READ_REPLY.value)),
            error.record.code.eq(Mux(is_port & ~code[0], code, Fault.WRITE_REPLY.value))]
        entry = Signal.like(self.taken)
        m.d.sync += [unwritten.eq(self.unwritten), is_far.eq(
            state.run & ((self.doorbell - self.taken)[:_COUNT_BITS] > 1 << self.kept.ring_bits))]
        m.d.comb += [
            entry.eq(self.taken & ((1 << self.kept.ring_bits) - 1)),
            error.clear.eq(commands["clear"]), error.culprit.eq(watch.culprit),
            error.record_fails.eq(self.unwritten & ~unwritten), error.record.number.eq(self.address),
            error.load_fails.eq(load.fails), error.load.eq(load.fault),
            error.ring_fails.eq(state.run & self.unread), error.ring.code.eq(load.read_code),
            error.ring.number.eq(self.kept.ring + (entry << 7) + (entry << 6)),
            error.is_far.eq(state.run & is_far), error.doorbell.eq(self.doorbell),
            error.wrong.eq((commands["resume"] & ~self.retry)
                           | (self.i_command.valid & ~self.i_command.payload[:len(_COMMANDS)].any())),
            self.error.eq(error.error), state.drains.eq(error.ring_fails | is_far),
            resets.eq(commands["stop"] | error.record_fails | (watch.culprit.code != ErrorCode.NONE))]
        return resets

    def _add_resume(self, m, commands, *, state, load, free):
        """When the queue may resume, and when registers of the ring and of windows are taken over."""
        can_resume = ~state.resuming & (state.halted | state.abort)
        m.d.comb += [
            self.retry.eq(commands["resume"] & can_resume), state.retry.eq(self.retry),
            state.copies.eq(self.i_command.payload[_COPIES]), self.enable.eq(state.run & ~load.busy),
            self.takes.eq(~self.memory_busy & (
                (state.run & free & (self.taken == self.doorbell))
                | (state.halted & ~load.busy & (self.empty | self.unwritten))
                | (state.abort & can_resume & self.unwritten))),
            self.stops.eq(state.stop), self.clear.eq(state.stop | commands["clear"] | self.o_load.valid)]
        with m.If(self.takes):
            m.d.sync += [getattr(self.kept, name).eq(getattr(self, name)) for name in self.kept.shape().members]

    def _add_registers(self, m, *, state, load, records, free):
        """What the host reads."""
        is_halted = ~state.live & ~state.resuming
        m.d.sync += self.taken.eq(self.taken + (self.i_sent.valid & state.live)
                                  + (self.i_load.valid & self.i_load.ready) + records.refuses)
        values = {
            "busy": ~free | state.stop | state.resuming | (state.live & (self.taken != self.doorbell)),
            "loading": load.reads, "halted": is_halted, "stops": state.stop, "loaded": self.loaded,
            "failed": self.error.code != ErrorCode.NONE, "unwritten": self.unwritten}
        for k, field in enumerate(register("status").fields):
            m.d.comb += self.status[k].eq(values[field.name])
        enable, pending = self.interrupt_value
        completed, was_halted = Signal.like(self.completed), Signal()
        m.d.sync += [completed.eq(self.completed), was_halted.eq(is_halted)]
        with m.If(self.i_interrupt.valid):
            m.d.sync += enable.eq(self.i_interrupt.payload[0])
            with m.If(self.i_interrupt.payload[1]):
                m.d.sync += pending.eq(0)
        with m.If((completed != self.completed) | (is_halted & ~was_halted)):
            m.d.sync += pending.eq(1)
        m.d.comb += self.irq.eq(enable & pending)
