"""What is around the control of jobs, and takes its time: a host, clusters, loads, records and main memory."""

import random
from collections import deque
from dataclasses import dataclass, field

from golden.engine.jobs.completion import NO_CLUSTER
from golden.engine.jobs.load_regions import LOADED_REGIONS
from hw.control.job_formats import IN_FLIGHT
from hw.noc.network_fault import NetworkFault
from hw.registers.error_code import ErrorCode

__all__ = ["COPIES", "IMAGE", "RING", "JobUnits", "Plan", "quiet"]

RING, COMPLETIONS, IMAGE = 0x1000, 0x9000, 0x40000
# The bit of the register `command` that is no command.
COPIES = 8
# Of the port; which one is a matter of the seed.
_WRITE_FAULTS = tuple(ErrorCode[f"WRITE_{name}"].value for name in ("TIMEOUT", "PROTOCOL", "OUTSIDE"))
_COMMANDS = {"stop": 1, "clear": 2, "resume": 4, "none": 0, "stop far": 1}


def quiet(clusters: int, patch_nodes: int = 0) -> dict:
    """The inputs of `JobControl` of as many clusters and patch nodes while nothing happens, by port.

    A stream is its payload or None, the ``ready`` of an output 0 or 1.
    """
    return {
        "i_command": None, "i_interrupt": None, "begins": 0, "i_sent": None, "i_load": None, "i_refused": None,
        "unread": 0, "dispatches": 0, "o_load": 1, "load_over": None, "i_collected": None, "source": 0, "o_record": 0,
        "completed": 0, "unwritten": 0, "empty": 1, "address": 0, "memory_busy": 0, "memory_fault": {},
        "clusters": [{}] * clusters, "networks": [NetworkFault.NONE.value] * (clusters + patch_nodes), "ring": RING,
        "completions": COMPLETIONS, "ring_bits": 3, "doorbell": 0, "image": IMAGE, "watchdog": 0}


@dataclass(frozen=True, kw_only=True)
class Plan:
    """What happens around the control.

    Parameters
    ----------
    nodes, seed, cycles
        Clusters; of all that is drawn; cycles of the run.
    first
        Descriptors that were submitted and taken before.
    kinds
        Of each descriptor: ``section``, ``load``, ``part`` (a load of some regions), ``refused`` or ``unread``.
    ring_bits, watchdog
        Registers.
    events
        By cycle what happens: ``stop``, ``clear``, ``resume``, ``none``, ``interrupt``; ``far``: a doorbell too far;
        ``unwritten``: the completion writer fails; ``timeout``, ``network``, ``local``: faults of a drawn cluster;
        ``timeout network``, ``stop far``: both at once; ``port reads``, ``port writes``: the port's first fault.
    slowest
        The longest time of a cast or of results.
    bad_loads
        How many of the first loads fail.
    resumes
        The host clears errors and resumes a halted queue.
    busiest
        The longest time for which main memory delays a reset.
    """

    nodes: int = 3
    seed: int = 1
    cycles: int = 400
    first: int = 0
    kinds: tuple[str, ...] = ("load", *("section",) * 12)
    ring_bits: int = 3
    watchdog: int = 0
    events: dict[int, str] = field(default_factory=dict)
    slowest: int = 20
    bad_loads: int = 0
    resumes: bool = True
    busiest: int = 6


class JobUnits:
    """The host and all units but the control; what they do depends on its outputs of earlier cycles alone.

    Members
    -------
    taken, completed
        Tags of the descriptors that were taken, and of the completion records, by the units' own account.
    records
        Records with their code.
    """

    def __init__(self, plan: Plan):
        self.plan, self._draw = plan, random.Random(plan.seed)
        self.taken, self.completed, self.records = [], [], []
        # The writer and the host are not reset.
        self._held, self._written, self._failed, self._collecting = deque(), 0, False, None
        self._doorbell, self._loads, self._wait, self._extra, self._stopped, self._idle_for = 0, 0, 0, 0, False, 0
        self._command, self._halted_for, self._repaired = None, 0, set()
        self._reset(0)

    def _reset(self, taken):
        self._next, self._phase, self._left, self._load, self._refusal = taken, "idle", 0, None, None
        nodes = self.plan.nodes
        # Of each cluster the sections in flight: the state and the cycles to its end.
        self._sections = [deque() for _ in range(nodes)]
        self._load_left = None
        self._faults, self._networks, self._memory = [{}] * nodes, [NetworkFault.NONE.value] * nodes, {}

    def give(self, cycle: int, values: dict | None) -> dict:
        """Inputs of a cycle by port, given the outputs of the one before."""
        draw, plan, event = self._draw, self.plan, self.plan.events.get(cycle)
        command = _COMMANDS.get(event)
        self._is_busy = values is not None and values["status"]["busy"]
        interrupt = draw.randrange(4) if event == "interrupt" else None
        self._host(values)
        if command is None and self._command is not None and event is None:
            command, self._command = self._command, None
        if command is not None and cycle % 2:
            # Of a resume alone it has an effect.
            command |= COPIES
        self._fault(event)
        begins = self._clusters()
        self._dispatch(values)
        self._collect()
        self._failed |= event == "unwritten"
        self._given = quiet(plan.nodes) | {
            "i_command": command, "i_interrupt": interrupt, "begins": begins, "i_sent": self._sent,
            "i_load": self._load, "i_refused": self._refusal, "unread": self._phase == "unread",
            "dispatches": self._phase in ("sending", "refused"),
            "o_load": self._load_left is None and draw.random() < 0.8, "load_over": self._over(),
            "i_collected": self._collected, "source": self._source,
            "o_record": self._collecting is None and not self._failed and len(self._held) < 4 and draw.random() < 0.4,
            "completed": self._written, "unwritten": self._failed,
            "empty": not self._held and self._collecting is None, "address": 64 * self._written,
            "memory_busy": self._wait > 0 or (self._is_busy and draw.random() < 0.1), "memory_fault": self._memory,
            "clusters": [*self._faults], "networks": [*self._networks], "ring_bits": plan.ring_bits,
            "watchdog": plan.watchdog, "doorbell": (plan.first + self._doorbell + self._extra) % (1 << 32)}
        return self._given

    def _host(self, values):
        """Descriptors are submitted while the rings have entries; a halted queue is resumed after some time."""
        draw = self._draw
        free = len(self.completed) + (1 << self.plan.ring_bits) - self._doorbell
        if values and self._doorbell < len(self.plan.kinds) and free > 0 and draw.random() < 0.3:
            self._doorbell += draw.randint(1, min(free, len(self.plan.kinds) - self._doorbell))
        self._halted_for = self._halted_for + 1 if values and values["status"]["halted"] and not values["stops"] else 0
        if self.plan.resumes and self._halted_for and self._halted_for % 9 == 4:
            self._extra, self._command = 0, 2
        elif self.plan.resumes and self._halted_for and self._halted_for % 9 == 8:
            self._command = 4

    def _fault(self, event):
        draw, k = self._draw, self._draw.randrange(self.plan.nodes)
        if event in ("timeout", "timeout network", "local"):
            code = ErrorCode.PATH_CELL if event == "local" else ErrorCode.PATH_TIMEOUT
            self._faults[k] = self._faults[k] or {"code": code.value, "number": draw.randrange(1 << 24)}
        if event in ("network", "timeout network"):
            self._networks[k] = NetworkFault.ORDER.value
        elif event in ("far", "stop far"):
            self._extra = (1 << self.plan.ring_bits) + len(self.plan.kinds)
        elif event in ("port reads", "port writes"):
            writes = _WRITE_FAULTS[self.plan.seed % len(_WRITE_FAULTS)]
            self._memory = {"code": ErrorCode.READ_OUTSIDE.value if event == "port reads" else writes, "address": 0x777}

    def _clusters(self):
        """Sections begin when the one before has been cast, and are cast and written in their order."""
        draw, begins = self._draw, 0
        for k, sections in enumerate(self._sections):
            casting = [one for one in sections if one["state"] == "cast"]
            for one in sections:
                one["left"] = max(0, one["left"] - 1)
                if one["state"] == "cast" and not one["left"] and not any(
                        other["state"] in ("written", "done") for other in sections):
                    one["state"], one["left"] = "written", draw.randint(1, self.plan.slowest)
                elif one["state"] == "written" and not one["left"]:
                    one["state"] = "done"
            waiting = next((one for one in sections if one["state"] == "slot"), None)
            if waiting and not casting and not waiting["left"]:
                waiting["state"], waiting["left"] = "cast", draw.randint(1, self.plan.slowest)
                begins |= 1 << k
        return begins

    def _dispatch(self, values):
        """One descriptor after the other."""
        draw, self._sent = self._draw, None
        kind = self.plan.kinds[self._next] if self._next < self._doorbell else None
        if self._phase == "idle" and values and values["enable"] and kind and draw.random() < 0.7:
            if kind == "unread" and self._next not in self._repaired:
                self._repaired.add(self._next)
                self._phase = "unread"
            elif kind in ("load", "part"):
                self._phase = "load"
                self._load = {"tag": self._tag, "image": 0x2000 + 64 * self._next, "copies": self._next % 3 == 0,
                              "regions": LOADED_REGIONS if kind == "load" else 1 << self._next % 7}
            else:
                self._phase, self._left = "sending", draw.randint(1, 6)
        elif self._phase == "sending":
            self._left = max(0, self._left - 1)
            free = [k for k, sections in enumerate(self._sections) if len(sections) < IN_FLIGHT
                    and all(one["state"] != "slot" for one in sections)]
            if not self._left and kind == "refused":
                self._phase = "refused"
                self._refusal = {"tag": self._tag, "code": ErrorCode.DESCRIPTOR.value, "cluster": NO_CLUSTER,
                                 "number": self._next, "begin": 0, "end": 0}
            elif not self._left and free:
                self._sent = {"cluster": draw.choice(free), "tag": self._tag}

    @property
    def _tag(self):
        return (self._next * 0x9E3779B1 + 5) % (1 << 32)

    def _over(self):
        if self._load_left is None or self._load_left > 0:
            return None
        self._loads += 1
        code = ErrorCode.READ_REPLY if self._loads % 2 else ErrorCode.POINTER
        return {"code": code.value, "address": 0x3000} if self._loads <= self.plan.bad_loads else {}

    def _collect(self):
        """The completion writer: one record after the other, answered in their order."""
        draw, self._collected = self._draw, None
        done = [k for k, sections in enumerate(self._sections) if sections and sections[0]["state"] == "done"]
        if self._collecting is not None:
            if draw.random() < 0.4:
                self._collected = self._collecting
        elif done and len(self._held) < 4 and draw.random() < 0.6:
            self._collecting = draw.choice(done)
        self._source = self._collecting if self._collecting is not None else draw.randrange(self.plan.nodes)
        self._answers = bool(self._held) and not self._failed and draw.random() < 0.3

    def after(self, values: dict) -> None:
        """What the outputs of the cycle change."""
        given, draw = self._given, self._draw
        begins_to_stop, self._stopped = values["stops"] and not self._stopped, values["stops"]
        # Main memory has outstanding transactions when a reset begins.
        self._wait = draw.randint(0, self.plan.busiest) if begins_to_stop else self._wait
        self._wait = max(0, self._wait - 1)
        if values["retry"]:
            self._failed = False
        record = values["o_record"]
        if record and given["o_record"]:
            self._held.append(record["tag"])
            self.completed.append(record["tag"])
            self.records.append(record)
        if values["stops"]:
            # Of the writer, only a record that was being collected is lost.
            self._collecting = None
            self._reset((values["taken"] - self.plan.first) % (1 << 32))
            return
        if self._load_left is not None:
            self._load_left = self._load_left - 1 if self._load_left else None
        if values["o_load"] and given["o_load"]:
            self._load_left = draw.randint(1, self.plan.slowest)
        if self._sent:
            self._sections[self._sent["cluster"]].append(
                {"tag": self._sent["tag"], "state": "slot", "left": draw.randint(0, 2)})
            self._go_on(self._sent["tag"])
        if self._load and values["i_load"]:
            self._go_on(self._load["tag"])
        if self._refusal and values["i_refused"]:
            self._go_on(self._refusal["tag"])
        if self._collected is not None:
            section = self._sections[self._collected].popleft()
            self._held.append(section["tag"])
            self.completed.append(section["tag"])
            self._collecting = None
        if self._answers:
            self._held.popleft()
            self._written += 1

    def is_over(self, cycle: int) -> bool:
        """All descriptors have their records, and all events have been for some time."""
        self._idle_for = 0 if self._is_busy or len(self.taken) < len(self.plan.kinds) else self._idle_for + 1
        return self._idle_for > 12 and cycle > max(self.plan.events, default=0) + 12

    def _go_on(self, tag):
        self.taken.append(tag)
        self._next, self._phase, self._load, self._refusal = self._next + 1, "idle", None, None
