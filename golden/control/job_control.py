"""Job control: which descriptors are in flight, when the queue halts, and what becomes of them then."""

from collections import deque
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from golden.jobs.completion import NO_CLUSTER
from golden.jobs.descriptor import DESCRIPTOR
from golden.jobs.load_regions import LOADED_REGIONS

__all__ = ["ABORTED", "COMMANDS", "COPIES", "RESETS", "STATUS", "Fault", "Inputs", "JobControl", "Load",
           "Outputs", "Record", "Registers"]

# Commands from bit 0 of the register on; the bit that says which tables a resume loads; the bits of the register
# ``status``.
COMMANDS = ("stop", "clear", "resume")
COPIES = len(COMMANDS)
STATUS = ("busy", "loading", "halted", "stops", "loaded", "failed", "unwritten")
ABORTED = "ABORTED"
# Errors that leave units in an undefined state.
RESETS = {"PATH_TIMEOUT", "NETWORK_CHECK", "NETWORK_ORDER", "NETWORK_ADDRESS", "WATCHDOG"}
_MODULUS = 1 << 32


@dataclass(frozen=True)
class Fault:
    """What the register ``error`` shows: code, cluster, and address or number."""

    code: str = "NONE"
    cluster: int = 0
    number: int = 0

    def __bool__(self):
        return self.code != "NONE"


_NONE = Fault()


@dataclass(frozen=True, kw_only=True)
class Registers:
    """Registers of the host."""

    ring: int = 0
    completions: int = 0
    ring_bits: int = 0
    doorbell: int = 0
    image: int = 0
    watchdog: int = 0


@dataclass(frozen=True, kw_only=True)
class Load:
    """A load of a descriptor; with ``copies`` all clusters get the tables of cluster 0."""

    tag: int = 0
    image: int = 0
    regions: int = LOADED_REGIONS
    copies: bool = False


@dataclass(frozen=True, kw_only=True)
class Record:
    """A completion record that no cluster writes."""

    tag: int = 0
    code: str = "NONE"
    cluster: int = NO_CLUSTER
    number: int = 0
    begin: int = 0
    end: int = 0


@dataclass(frozen=True, kw_only=True)
class Inputs:
    """Inputs of the control in a cycle.

    Parameters
    ----------
    command, interrupt
        Writes to these registers, or none.
    registers
        Those of the host.
    begins
        Clusters that begin to cast the next one of their sections.
    sent
        Cluster and tag of a section that has been sent, or none.
    load, refusal
        A load and a refused descriptor's record that the dispatch offers, or none.
    unread, dispatches
        The next descriptor could not be read; a descriptor is being sent, checked or refused.
    can_load, load_over
        The load control accepts a load; how its load ends in this cycle, or none.
    collected, source
        The cluster whose section's record has been collected, or none, and the one whose tag is requested.
    record_taken
        A record that is offered is accepted.
    completed, unwritten, empty, address
        Of the completion writer: records written, whether it has failed, whether it holds none, where the oldest is.
    memory_busy, memory
        Main memory has an outstanding transaction; the first fault of its port.
    clusters, networks
        Faults of each cluster and of each network interface.
    """

    command: int | None = None
    interrupt: int | None = None
    registers: Registers = Registers()
    begins: frozenset[int] = frozenset()
    sent: tuple[int, int] | None = None
    load: Load | None = None
    refusal: Record | None = None
    unread: bool = False
    dispatches: bool = False
    can_load: bool = False
    load_over: Fault | None = None
    collected: int | None = None
    source: int = 0
    record_taken: bool = False
    completed: int = 0
    unwritten: bool = False
    empty: bool = True
    address: int = 0
    memory_busy: bool = False
    memory: Fault = _NONE
    clusters: tuple[Fault, ...]
    networks: tuple[Fault, ...]

    @property
    def command_name(self) -> str | None:
        """The command by name; of several the lowest bit counts; "none" if no bit is set."""
        if self.command is None:
            return None
        return next((name for bit, name in enumerate(COMMANDS) if self.command >> bit & 1), "none")


@dataclass(frozen=True, kw_only=True)
class Outputs:
    """Outputs of the control in a cycle.

    Parameters
    ----------
    stops, clear, enable, loaded, retry
        Units are reset; faults of the port are cleared; descriptors may be taken; all tables are loaded; the completion
        writer tries again.
    takes_load
        A load of the dispatch is accepted.
    load, record
        The load and the record that are offered, or none.
    tag
        Of the oldest section of the cluster ``source``, None if there is none.
    taken, status, error
        The registers.
    enabled, pending
        Of the interrupt.
    takes
        The registers of the ring and the windows are taken over.
    ring, completions, ring_bits
        Those that have been.
    """

    stops: bool
    clear: bool
    enable: bool
    loaded: bool
    retry: bool
    takes_load: bool
    load: Load | None
    record: Record | None
    tag: int | None
    taken: int
    status: Mapping[str, bool]
    error: Fault
    enabled: bool
    pending: bool
    takes: bool
    ring: int
    completions: int
    ring_bits: int


@dataclass
class _Section:
    """A section in flight."""

    tag: int
    begun: bool = False


@dataclass
class _Load:
    """The load in flight: ``phase`` is offered, read, or over."""

    given: Load
    is_resume: bool
    begin: int
    phase: str = "offered"
    fault: Fault = _NONE
    end: int = 0
    age: int = 0


@dataclass
class _Watch:
    """The watchdog of a cluster: cycles since it was restarted."""

    age: int = 0
    restarts: bool = True


@dataclass(frozen=True)
class _Culprit:
    """Which descriptor has caused the reset: a cluster's oldest section or the one begun last, or (None) the load."""

    fault: Fault
    cluster: int | None
    newest: bool = False


@dataclass
class _Events:
    """What happens in a cycle, as faults in the order in which they become ``error``."""

    faults: list[Fault] = field(default_factory=list)
    culprit: _Culprit | None = None
    resets: bool = False


class JobControl:
    """The control by its rules, one cycle per step.

    In state ``run`` it takes descriptors. In ``drain`` it takes none, and those in flight end before ``stop``, in which
    the units are in reset until main memory has no outstanding transaction. In ``abort`` each descriptor that was in
    flight gets a record, cluster by cluster, then a load. In ``halted`` it waits for a resume, whose load ends in
    ``run``.

    Parameters
    ----------
    nodes
        Number of clusters.
    """

    def __init__(self, *, nodes: int):
        self._nodes, self._cycle, self._state = nodes, 0, "run"
        self._sections = [deque() for _ in range(nodes)]
        self._watches = [_Watch() for _ in range(nodes)]
        self._load: _Load | None = None
        self._taken, self._loaded, self._resuming, self._copies = 0, False, False, False
        self._error, self._culprit = Fault(), None
        self._enabled = self._pending = False
        self._kept = Registers()
        # Of the cycle before.
        self._polled, self._late, self._load_late, self._far = (), None, False, False
        self._unwritten, self._completed, self._halted = False, 0, False
        # The cluster whose sections are being aborted.
        self._cluster = 0

    def step(self, given: Inputs) -> Outputs:
        """The outputs in the cycle with these inputs."""
        outputs = self._outputs(given)
        events = self._events(given, outputs)
        state = self._next_state(given, events)
        self._keep_error(given, events)
        self._keep_interrupt(given, outputs)
        self._poll(given)
        self._watch(given)
        self._far = self._state == "run" and (
            (given.registers.doorbell - self._taken) % _MODULUS > 1 << self._kept.ring_bits)
        if outputs.takes:
            self._kept = given.registers
        self._keep_load(given, outputs, state)
        self._keep_sections(given, outputs)
        if state == "stop" and self._live:
            self._culprit = events.culprit
        if self._state == "stop":
            self._loaded = self._resuming = False
            if self._load and self._load.is_resume:
                self._load = None
        self._state, self._cycle = state, (self._cycle + 1) % _MODULUS
        return outputs

    @property
    def _live(self):
        return self._state in ("run", "drain")

    def _outputs(self, given):
        state, load, waits = self._state, self._load, any(self._sections)
        command, halted = given.command_name, self._is_halted
        free = not (waits or load or given.dispatches) and given.empty
        even = self._taken == given.registers.doorbell
        idle = given.empty or given.unwritten
        can_resume = not self._resuming and state in ("abort", "halted")
        may = {"run": free and even, "halted": not load and idle, "abort": can_resume and given.unwritten}
        takes = not given.memory_busy and may.get(state, False)
        reads = bool(load) and load.phase != "over" and state not in ("stop", "abort")
        offers = reads and load.phase == "offered"
        busy = not free or state == "stop" or self._resuming or (self._live and not even)
        section = self._sections[given.source]
        return Outputs(
            stops=state == "stop", clear=state == "stop" or command == "clear" or offers,
            enable=state == "run" and not load, loaded=self._loaded, retry=command == "resume" and can_resume,
            takes_load=state == "run" and not load and not waits,
            load=load.given if offers else None,
            record=self._record(given), tag=section[0].tag if section and self._live else None, taken=self._taken,
            status=dict(zip(STATUS, (busy, reads, halted, state == "stop", self._loaded, bool(self._error),
                                     given.unwritten), strict=True)),
            error=self._error, enabled=self._enabled, pending=self._pending, takes=takes, ring=self._kept.ring,
            completions=self._kept.completions, ring_bits=self._kept.ring_bits)

    @property
    def _is_halted(self):
        return not self._live and not self._resuming

    def _record(self, given):
        """The record that is offered: of what is aborted, of a load that is over, or of a refusal."""
        load = self._load
        over = load and load.phase == "over" and Record(
            tag=load.given.tag, code=load.fault.code, number=load.fault.number, begin=load.begin, end=load.end)
        if self._live:
            return over or given.refusal
        if self._state != "abort":
            return None
        blame = self._culprit
        if self._cluster == self._nodes:
            if not load or over:
                return over
            code = blame.fault.code if blame and blame.cluster is None else ABORTED
            return Record(tag=load.given.tag, code=code)
        sections = self._sections[self._cluster]
        if not sections:
            return None
        is_culprit = blame and blame.cluster == self._cluster and (
            not blame.newest or sum(one.begun for one in sections) == 1)
        fault = blame.fault if is_culprit else Fault(ABORTED)
        return Record(tag=sections[0].tag, code=fault.code, cluster=self._cluster, number=fault.number)

    def _events(self, given, outputs):
        events, command = _Events(), given.command_name
        load = self._load

        def blame(fault, cluster, newest=False):
            events.resets = True
            events.culprit = events.culprit or _Culprit(fault, cluster, newest)

        def port(kind):
            return given.memory.code if given.memory.code.startswith(kind) else f"{kind}_REPLY"

        if self._late is not None:
            events.faults.append(Fault("WATCHDOG", self._late))
            blame(Fault("WATCHDOG"), self._late)
        if self._load_late:
            events.faults.append(Fault("WATCHDOG"))
            blame(Fault("WATCHDOG"), None)
        if given.unwritten and not self._unwritten:
            events.faults.append(Fault(port("WRITE"), 0, given.address))
            events.resets = True
        if load and load.is_resume and given.load_over and self._state != "stop":
            events.faults.append(self._refined(given))
        for one in self._polled:
            events.faults.append(one)
            blame(Fault(one.code, 0, one.number), one.cluster, newest=True)
        if self._state == "run" and given.unread:
            entry = self._taken % (1 << self._kept.ring_bits)
            events.faults.append(Fault(port("READ"), 0, self._kept.ring + entry * DESCRIPTOR.dtype.itemsize))
        if self._state == "run" and self._far:
            events.faults.append(Fault("RING", 0, given.registers.doorbell))
        if command == "none" or (command == "resume" and not outputs.retry):
            events.faults.append(Fault("COMMAND"))
        events.resets = events.resets or command == "stop"
        return events

    @staticmethod
    def _refined(given):
        """The fault of a load; the port knows which fault of a read it was."""
        over, memory = given.load_over, given.memory
        return replace(over, code=memory.code) if over.code == "READ_REPLY" and memory.code.startswith("READ") else over

    def _next_state(self, given, events):
        state, load = self._state, self._load
        if state == "stop":
            return "stop" if given.memory_busy else "abort"
        if events.resets:
            return "stop"
        if state == "run":
            return "drain" if given.unread or self._far else "run"
        if state == "drain":
            in_flight = any(self._sections) or load or given.dispatches or not given.empty
            return "drain" if in_flight else "stop"
        if state == "abort":
            return "halted" if self._cluster == self._nodes and not load else "abort"
        ends = load and given.load_over is not None and not given.load_over
        return "run" if ends else "halted"

    def _keep_error(self, given, events):
        """The first error stays until it is cleared; those in the cycle of a clear come after it."""
        if given.command_name == "clear":
            self._error = Fault()
        if not self._error:
            self._error = next(iter(filter(None, events.faults)), Fault())

    def _keep_interrupt(self, given, outputs):
        """Pending when a record has been written and when the queue halts."""
        if given.interrupt is not None:
            self._enabled = bool(given.interrupt & 1)
            self._pending = self._pending and not given.interrupt & 2
        if given.completed != self._completed or (outputs.status["halted"] and not self._halted):
            self._pending = True
        self._completed, self._halted, self._unwritten = given.completed, outputs.status["halted"], given.unwritten

    def _poll(self, given):
        """One cluster per cycle, in turn; only faults that end in a reset."""
        number = self._cycle % self._nodes
        found = (given.clusters[number], given.networks[number])
        self._polled = () if self._state == "stop" else tuple(
            Fault(one.code, number, one.number) for one in found if one.code in RESETS)[:1]

    def _watch(self, given):
        """The cluster polled has sections, and none of them was completed for too long; or the load takes too long."""
        number, limit = self._cycle % self._nodes, given.registers.watchdog
        watch, sections = self._watches[number], self._sections[number]
        counts = self._live and bool(sections) and not watch.restarts
        self._late = number if counts and 0 < limit <= watch.age else None
        watch.age = watch.age + self._nodes if counts else 0
        watch.restarts = False
        load = self._load
        reads = load is not None and load.phase != "over" and self._state not in ("stop", "abort")
        self._load_late = reads and 0 < limit <= load.age
        if load:
            load.age = load.age + 1 if reads else 0

    def _keep_load(self, given, outputs, state):
        """A load is offered, read, and over; its record ends it."""
        load = self._load
        if outputs.retry:
            self._resuming, self._copies = True, bool(given.command >> COPIES & 1)
        if load is None:
            if outputs.takes_load and given.load:
                self._load = _Load(given.load, False, self._cycle)
                self._taken = (self._taken + 1) % _MODULUS
            elif outputs.takes and self._resuming and not outputs.retry and state == self._state == "halted":
                self._load = _Load(Load(image=given.registers.image, copies=self._copies), True, self._cycle)
            return
        if load.phase == "over":
            if given.record_taken and outputs.record and (self._live or self._cluster == self._nodes):
                self._load = None
        elif self._state == "abort":
            if given.record_taken and outputs.record and self._cluster == self._nodes:
                self._load = None
        elif self._state != "stop" and given.load_over is not None:
            complete = load.given.regions & LOADED_REGIONS == LOADED_REGIONS
            self._loaded = not given.load_over and (self._loaded or complete)
            load.phase, load.fault, load.end = "over", self._refined(given), self._cycle
            if load.is_resume:
                self._load, self._resuming = None, False
        elif load.phase == "offered" and given.can_load and self._state != "stop":
            load.phase = "read"

    def _keep_sections(self, given, outputs):
        """Sections are sent, begin, and are collected; in a reset nothing happens."""
        if self._live:
            for cluster in given.begins:
                next(one for one in self._sections[cluster] if not one.begun).begun = True
            empty = given.sent and not self._sections[given.sent[0]]
            if given.collected is not None:
                self._sections[given.collected].popleft()
                self._watches[given.collected].restarts = True
            if given.sent:
                cluster, tag = given.sent
                self._sections[cluster].append(_Section(tag))
                self._taken = (self._taken + 1) % _MODULUS
                self._watches[cluster].restarts |= empty
            refused = given.refusal and outputs.record is given.refusal
            if refused and given.record_taken:
                self._taken = (self._taken + 1) % _MODULUS
        elif self._state == "stop":
            self._cluster = 0
        elif self._state == "abort" and self._cluster < self._nodes:
            sections = self._sections[self._cluster]
            if not sections:
                self._cluster += 1
            elif given.record_taken:
                # One descriptor is to blame.
                if outputs.record.code != ABORTED:
                    self._culprit = None
                sections.popleft()
