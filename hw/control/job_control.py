"""Job control: which descriptors are in flight, when the queue halts, and what becomes of them then."""

from amaranth.hdl import Array, Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from golden.engine.jobs.completion import NO_CLUSTER
from hw.control.control_formats import ControlFormats
from hw.control.job_formats import IN_FLIGHT, JobFormats
from hw.control.load_control import ALL
from hw.lib.validate import check_instance
from hw.memsys.port.fault import Fault
from hw.memsys.port.memory_formats import MemoryFormats
from hw.noc.network_fault import NetworkFault
from hw.registers.engine_registers import RING_BITS, register
from hw.registers.error_code import NETWORK, ErrorCode

__all__ = ["JobControl"]

# From bit 0 of the register on; the last one is no command, but says what a resume loads.
*_COMMANDS, _ = (field.name for field in register("command").fields)
_COPIES = len(_COMMANDS)
_INDEX_BITS = IN_FLIGHT.bit_length()
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
    What main memory has answered to a load, to the ring or to a record has the code of the port's first fault, if that
    is of the same direction.

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
    begins : In(nodes)
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
    clusters : In(ArrayLayout(ControlFormats.fault, nodes))
        Faults of the clusters; only time-outs have an effect.
    networks : In(ArrayLayout(NetworkFault, nodes))
        Faults of their network interfaces.
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
        self._formats = formats = JobFormats(config)
        nodes, address = config.noc.nodes, config.memory.address_bits

        def event(layout):
            return In(stream.Signature(layout, always_ready=True))

        super().__init__({
            "i_command": event(register("command").width), "i_interrupt": event(register("interrupt").width),
            **{name: In(64) for name in ("ring", "completions", "image")}, "ring_bits": In(RING_BITS),
            "doorbell": In(_COUNT_BITS), "watchdog": In(_COUNT_BITS),
            "kept": Out(StructLayout({"ring": address, "completions": address, "ring_bits": RING_BITS})),
            **{name: Out(1) for name in ("takes", "stops", "clear", "enable", "loaded")}, "begins": In(nodes),
            "i_sent": event(formats.sent), "i_load": In(stream.Signature(formats.load_job)),
            "i_refused": In(stream.Signature(formats.record)), "unread": In(1), "dispatches": In(1),
            "o_load": Out(stream.Signature(formats.load)), "load_over": event(memory.fault),
            "source": In(formats.cluster), "tag": Out(32), "i_collected": event(formats.cluster),
            "o_record": Out(stream.Signature(formats.record)), "completed": In(_COUNT_BITS), "empty": In(1),
            "unwritten": In(1), "address": In(address), "retry": Out(1), "memory_busy": In(1),
            "memory_fault": In(memory.fault), "clusters": In(ArrayLayout(control.fault, nodes)),
            "networks": In(ArrayLayout(NetworkFault, nodes)), "taken": Out(_COUNT_BITS),
            "status": Out(register("status").width), "error": Out(control.error), "cycles": Out(_COUNT_BITS),
            "interrupt_value": Out(register("interrupt").width), "irq": Out(1)})

    def elaborate(self, platform):
        m = Module()
        self._state = {name: Signal(name=f"is_{name}", init=name == "run") for name in (
            "run", "drain", "stop", "abort", "halted")}
        self._live, self._resets = Signal(), Signal()
        self._commands = {name: Signal(name=f"command_{name}") for name in _COMMANDS}
        self._resuming, self._copies, self._is_halted = Signal(), Signal(), Signal()
        command, before = self.i_command, 0
        for k, bit in enumerate(self._commands.values()):
            m.d.comb += bit.eq(command.valid & command.payload[k] & ~before)
            before = command.payload[:k + 1].any()
        m.d.comb += [self._live.eq(self._state["run"] | self._state["drain"]), self.stops.eq(self._state["stop"]),
                     self._is_halted.eq(~self._live & ~self._resuming)]
        m.d.sync += self.cycles.eq(self.cycles + 1)
        self._add_table(m)
        self._add_load(m)
        self._add_records(m)
        self._add_watch(m)
        self._add_errors(m)
        self._add_states(m)
        self._add_registers(m)
        return m

    def _add_table(self, m):
        """Sections in flight, cluster by cluster: how many, how many of them have begun, and their tags."""
        nodes = self._config.noc.nodes
        m.submodules.tags = tags = Memory(shape=32, depth=nodes << _INDEX_BITS, init=[],
                                          attrs={"ram_style": "distributed"})
        self._counts, self._begun, oldest = ([Signal(_INDEX_BITS, name=f"{name}_{k}") for k in range(nodes)]
                                             for name in ("count", "begun", "oldest"))
        write, read = tags.write_port(), tags.read_port(domain="comb")
        sent, number = self.i_sent.payload, Signal(range(nodes + 1))
        self._aborts, self._cluster = Signal(), Signal(range(nodes + 1))
        newest = Array(head + count for head, count in zip(oldest, self._counts, strict=True))
        m.d.comb += [
            number.eq(Mux(self._state["abort"], self._cluster, self.source)), self.tag.eq(read.data),
            read.addr.eq(Cat(Array(oldest)[number], number)), write.en.eq(self.i_sent.valid & self._live),
            write.addr.eq(Cat(newest[sent.cluster][:_INDEX_BITS], sent.cluster)), write.data.eq(sent.tag)]
        self._restarts = Signal(nodes)
        for k in range(nodes):
            pushes, pops, aborts = Signal(name=f"pushes_{k}"), Signal(name=f"pops_{k}"), Signal(name=f"aborts_{k}")
            m.d.comb += [
                pushes.eq(write.en & (sent.cluster == k)), aborts.eq(self._aborts & (self._cluster == k)),
                pops.eq(aborts | (self.i_collected.valid & self._live & (self.i_collected.payload == k))),
                self._restarts[k].eq((pushes & (self._counts[k] == 0)) | (pops & ~aborts))]
            m.d.sync += [
                self._counts[k].eq(self._counts[k] + pushes - pops), oldest[k].eq(oldest[k] + pops),
                self._begun[k].eq(self._begun[k] + (self.begins[k] & self._live) - (pops & (self._begun[k] != 0)))]
        self._waits = Signal()
        m.d.comb += self._waits.eq(Cat(*self._counts).any())

    def _add_load(self, m):
        """A load is offered, read, and over; that of a resume has no record."""
        load, given = Signal.like(self.o_load.payload), self.i_load.payload
        self._load = {name: Signal(name=f"load_{name}") for name in ("offered", "read", "over", "resumes")}
        self._load_tag = Signal(32)
        phases, over = self._load, self.load_over
        self._has_load = has_load = Signal()
        self._reads, self._load_fault, number = Signal(), Signal(ErrorCode), Signal.like(over.payload.address)
        self._load_number, self._load_begin, self._load_end = number, Signal(_COUNT_BITS), Signal(_COUNT_BITS)
        active, read_fault = Signal(), self._direction(1)
        m.d.comb += [
            has_load.eq(phases["offered"] | phases["read"] | phases["over"]),
            active.eq(~self._state["stop"] & ~self._state["abort"]),
            self._reads.eq((phases["offered"] | phases["read"]) & active),
            self.o_load.valid.eq(phases["offered"] & active), self.o_load.payload.eq(load),
            self.i_load.ready.eq(self._state["run"] & ~has_load & ~self._waits)]
        self._over, self._over_code = Signal(), Signal(ErrorCode)
        m.d.comb += [self._over.eq(over.valid & active),
                     self._over_code.eq(Mux((over.payload.code == Fault.READ_REPLY) & read_fault,
                                            self.memory_fault.code.as_value(), over.payload.code.as_value()))]
        with m.If(self.i_load.valid & self.i_load.ready):
            m.d.sync += [phases["offered"].eq(1), phases["resumes"].eq(0), self._load_tag.eq(given.tag),
                         self._load_begin.eq(self.cycles),
                         *(load[name].eq(given[name]) for name, _ in load.shape())]
        with m.Elif(self._state["halted"] & self.takes & self._resuming & ~self._resets):
            m.d.sync += [phases["offered"].eq(1), phases["resumes"].eq(1), load.image.eq(self.image),
                         load.regions.eq((1 << len(load.regions)) - 1), load.copies.eq(self._copies)]
        with m.If(self.o_load.valid & self.o_load.ready):
            m.d.sync += [phases["offered"].eq(0), phases["read"].eq(1)]
        with m.If(self._over):
            m.d.sync += [
                phases["offered"].eq(0), phases["read"].eq(0), phases["over"].eq(~phases["resumes"]),
                self._load_fault.eq(self._over_code), number.eq(over.payload.address), self._load_end.eq(self.cycles),
                self.loaded.eq((over.payload.code == Fault.NONE) & (self.loaded | ((load.regions & ALL) == ALL)))]
        with m.If(self._state["stop"]):
            m.d.sync += self.loaded.eq(0)
            with m.If(phases["resumes"]):
                m.d.sync += [phases["offered"].eq(0), phases["read"].eq(0)]

    def _direction(self, odd):
        """The port's first fault is one of reads (odd), or of writes."""
        code = self.memory_fault.code.as_value()
        return (code != 0) & (code <= Fault.WRITE_PROTOCOL.value) & (code[0] == odd)

    def _add_records(self, m):
        """Records of what is aborted, of a load that is over, and of refusals."""
        record, out, phases = self.o_record.payload, self.o_record, self._load
        nodes = self._config.noc.nodes
        self._culprit = culprit = Signal(StructLayout({
            "code": ErrorCode, "number": self.error.number.shape(), "is_load": 1, "newest": 1,
            "cluster": self._formats.cluster}))
        count = Array([*self._counts, 0])[self._cluster]
        begun = Array([*self._begun, 0])[self._cluster]
        at_load, blamed, taken = Signal(), Signal(), Signal()
        m.d.comb += [at_load.eq(self._cluster == nodes), taken.eq(out.valid & out.ready),
                     self._aborts.eq(self._state["abort"] & ~at_load & taken)]
        self._refuses, self._load_ends, self._aborted = Signal(), Signal(), Signal()
        over = [record.tag.eq(self._load_tag), record.code.eq(self._load_fault), record.number.eq(self._load_number),
                record.begin.eq(self._load_begin), record.end.eq(self._load_end), record.cluster.eq(NO_CLUSTER)]
        with m.If(self._live):
            with m.If(phases["over"]):
                m.d.comb += [out.valid.eq(1), *over, self._load_ends.eq(taken)]
            with m.Else():
                m.d.comb += [out.valid.eq(self.i_refused.valid), record.eq(self.i_refused.payload),
                             self.i_refused.ready.eq(out.ready), self._refuses.eq(taken)]
        with m.Elif(self._state["abort"] & at_load):
            m.d.comb += [out.valid.eq(self._has_load), self._load_ends.eq(taken), self._aborted.eq(~self._has_load)]
            with m.If(phases["over"]):
                m.d.comb += over
            with m.Else():
                m.d.comb += [record.tag.eq(self._load_tag), record.cluster.eq(NO_CLUSTER), record.code.eq(Mux(
                    (culprit.code != ErrorCode.NONE) & culprit.is_load, culprit.code, ErrorCode.ABORTED))]
        with m.Elif(self._state["abort"]):
            m.d.comb += [
                blamed.eq((culprit.code != ErrorCode.NONE) & ~culprit.is_load & (culprit.cluster == self._cluster)
                          & (~culprit.newest | (begun == 1))),
                out.valid.eq(count != 0), record.tag.eq(self.tag), record.cluster.eq(self._cluster),
                record.code.eq(Mux(blamed, culprit.code, ErrorCode.ABORTED)),
                record.number.eq(Mux(blamed, culprit.number, 0))]
            with m.If(count == 0):
                m.d.sync += self._cluster.eq(self._cluster + 1)
            with m.If(taken & blamed):
                m.d.sync += culprit.code.eq(ErrorCode.NONE)
        with m.If(self._state["stop"]):
            m.d.sync += self._cluster.eq(0)
        with m.If(self._load_ends):
            m.d.sync += [phases["offered"].eq(0), phases["read"].eq(0), phases["over"].eq(0)]

    def _add_watch(self, m):
        """The watchdogs, and the faults of clusters and networks: one cluster per cycle."""
        nodes = self._config.noc.nodes
        self._number, restarts = Signal(range(nodes)), Signal(nodes, init=(1 << nodes) - 1)
        polled = 1 << self._number
        m.d.sync += [self._number.eq(Mux(self._number == nodes - 1, 0, self._number + 1)),
                     restarts.eq((restarts & ~polled) | self._restarts)]
        m.submodules.ages = ages = Memory(shape=_COUNT_BITS, depth=max(2, nodes), init=[],
                                          attrs={"ram_style": "distributed"})
        read, write, counts, limit = ages.read_port(domain="comb"), ages.write_port(), Signal(), self.watchdog
        m.d.comb += [
            counts.eq(self._live & (Array(self._counts)[self._number] != 0) & ~restarts.bit_select(self._number, 1)),
            read.addr.eq(self._number), write.addr.eq(self._number), write.en.eq(1),
            write.data.eq(Mux(counts, read.data + nodes, 0))]
        self._late, self._previous = Signal(), Signal.like(self._number)
        self._load_late, load_age = Signal(), Signal(_COUNT_BITS)
        m.d.sync += [self._late.eq(counts & (limit != 0) & (read.data >= limit)), self._previous.eq(self._number),
                     self._load_late.eq(self._reads & (limit != 0) & (load_age >= limit)),
                     load_age.eq(Mux(self._reads, load_age + 1, 0))]
        self._fault, self._network = Signal.like(self.clusters[0]), Signal(NetworkFault)
        fault = Signal.like(self.clusters[0])
        m.d.comb += fault.eq(Array(self.clusters[k].as_value() for k in range(nodes))[self._number])
        m.d.sync += [self._fault.as_value().eq(Mux(fault.code == ErrorCode.PATH_TIMEOUT, fault, 0)),
                     self._network.eq(Array(self.networks[k].as_value() for k in range(nodes))[self._number])]
        with m.If(self._state["stop"]):
            m.d.sync += [self._fault.as_value().eq(0), self._network.eq(NetworkFault.NONE)]

    def _add_errors(self, m):
        """The first error, and the descriptor that has caused a reset."""
        error, previous, culprit = self.error, self._previous, self._culprit
        unwritten, far = Signal(), Signal()
        resumes = self._commands["resume"]
        m.d.sync += [unwritten.eq(self.unwritten), far.eq(
            self._state["run"] & ((self.doorbell - self.taken)[:_COUNT_BITS] > 1 << self.kept.ring_bits))]
        self._ring_fails, self._is_far, fails = Signal(), far, Signal()
        entry = Signal.like(self.taken)
        m.d.comb += [
            fails.eq(self.unwritten & ~unwritten), self._ring_fails.eq(self._state["run"] & self.unread),
            entry.eq(self.taken & ((1 << self.kept.ring_bits) - 1)),
            self._resets.eq(self._commands["stop"] | self._late | self._load_late | fails
                            | (self._fault.code != ErrorCode.NONE) | (self._network != NetworkFault.NONE))]
        wrong = (resumes & ~self.retry) | (self.i_command.valid & ~self.i_command.payload[:len(_COMMANDS)].any())
        with m.If(self._commands["clear"]):
            m.d.sync += error.as_value().eq(0)

        def latch(code, cluster=0, number=0):
            m.d.sync += [error.code.eq(code), error.cluster.eq(cluster), error.number.eq(number)]

        with m.If(self._commands["clear"] | (error.code == ErrorCode.NONE)):
            with m.If(self._late):
                latch(ErrorCode.WATCHDOG, previous)
            with m.Elif(self._load_late):
                latch(ErrorCode.WATCHDOG)
            with m.Elif(fails):
                latch(Mux(self._direction(0), self.memory_fault.code.as_value(), Fault.WRITE_REPLY.value), 0,
                      self.address)
            with m.Elif(self._over & self._load["resumes"] & (self.load_over.payload.code != Fault.NONE)):
                latch(self._over_code, 0, self.load_over.payload.address)
            with m.Elif(self._fault.code != ErrorCode.NONE):
                latch(self._fault.code, previous, self._fault.number)
            with m.Elif(self._network != NetworkFault.NONE):
                latch(self._network.as_value() + NETWORK, previous)
            with m.Elif(self._ring_fails):
                latch(Mux(self._direction(1), self.memory_fault.code.as_value(), Fault.READ_REPLY.value), 0,
                      self.kept.ring + (entry << 7) + (entry << 6))
            with m.Elif(self._state["run"] & far):
                latch(ErrorCode.RING, 0, self.doorbell)
            with m.Elif(wrong):
                latch(ErrorCode.COMMAND)
        with m.If(self._live & (self._resets | self._state["drain"])):
            m.d.sync += culprit.as_value().eq(0)
            with m.If(self._late):
                m.d.sync += [culprit.code.eq(ErrorCode.WATCHDOG), culprit.cluster.eq(previous)]
            with m.Elif(self._load_late):
                m.d.sync += [culprit.code.eq(ErrorCode.WATCHDOG), culprit.is_load.eq(1)]
            with m.Elif(self._fault.code != ErrorCode.NONE):
                m.d.sync += [culprit.code.eq(self._fault.code), culprit.number.eq(self._fault.number),
                             culprit.cluster.eq(previous), culprit.newest.eq(1)]
            with m.Elif(self._network != NetworkFault.NONE):
                m.d.sync += [culprit.code.eq(self._network.as_value() + NETWORK), culprit.cluster.eq(previous),
                             culprit.newest.eq(1)]

    def _add_states(self, m):
        """From state to state, one bit each."""
        state, following = self._state, {}
        ends = self._over & (self.load_over.payload.code == Fault.NONE)
        drained = ~(self._waits | self._has_load | self.dispatches) & self.empty
        moves = {
            ("run", "drain"): self._ring_fails | self._is_far, ("drain", "stop"): drained,
            ("stop", "abort"): ~self.memory_busy, ("abort", "halted"): self._aborted,
            ("halted", "run"): ends}
        for (source, target), condition in moves.items():
            following[target] = following.get(target, 0) | (state[source] & condition)
        for (source, _), condition in moves.items():
            following[source] = following.get(source, 0) | (state[source] & ~condition)
        stops = self._resets & ~state["stop"]
        for name, value in following.items():
            m.d.sync += state[name].eq(Mux(stops, name == "stop", value))
        with m.If(self.retry):
            m.d.sync += [self._resuming.eq(1), self._copies.eq(self.i_command.payload[_COPIES])]
        with m.Elif(state["stop"] | (self._over & self._load["resumes"])):
            m.d.sync += self._resuming.eq(0)

    def _add_registers(self, m):
        """What the host reads, and what is taken over of what it writes."""
        state, has_load = self._state, self._has_load
        free, even, can_resume = Signal(), Signal(), Signal()
        m.d.comb += [
            free.eq(~(self._waits | has_load | self.dispatches) & self.empty), even.eq(self.taken == self.doorbell),
            can_resume.eq(~self._resuming & (state["halted"] | state["abort"])),
            self.retry.eq(self._commands["resume"] & can_resume), self.enable.eq(state["run"] & ~has_load),
            self.takes.eq(~self.memory_busy & (
                (state["run"] & free & even)
                | (state["halted"] & ~has_load & (self.empty | self.unwritten))
                | (state["abort"] & can_resume & self.unwritten))),
            self.clear.eq(state["stop"] | self._commands["clear"] | self.o_load.valid)]
        with m.If(self.takes):
            m.d.sync += [getattr(self.kept, name).eq(getattr(self, name)) for name in self.kept.shape().members]
        m.d.sync += self.taken.eq(self.taken + (self.i_sent.valid & self._live)
                                  + (self.i_load.valid & self.i_load.ready) + self._refuses)
        values = {
            "busy": ~free | state["stop"] | self._resuming | (self._live & ~even), "loading": self._reads,
            "halted": self._is_halted, "stops": state["stop"], "loaded": self.loaded,
            "failed": self.error.code != ErrorCode.NONE, "unwritten": self.unwritten}
        for k, field in enumerate(register("status").fields):
            m.d.comb += self.status[k].eq(values[field.name])
        enable, pending = self.interrupt_value
        completed, was_halted = Signal.like(self.completed), Signal()
        m.d.sync += [completed.eq(self.completed), was_halted.eq(self._is_halted)]
        with m.If(self.i_interrupt.valid):
            m.d.sync += enable.eq(self.i_interrupt.payload[0])
            with m.If(self.i_interrupt.payload[1]):
                m.d.sync += pending.eq(0)
        with m.If((completed != self.completed) | (self._is_halted & ~was_halted)):
            m.d.sync += pending.eq(1)
        m.d.comb += self.irq.eq(enable & pending)
