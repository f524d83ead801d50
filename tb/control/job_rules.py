"""The rules of `JobControl`, one by one, for every cycle of every run."""

from collections import deque

from golden.engine.jobs.completion import NO_CLUSTER
from golden.engine.jobs.descriptor import DESCRIPTOR
from golden.engine.jobs.load_regions import LOADED_REGIONS
from golden.engine.memory_map import REGIONS
from hw.registers.error_code import NETWORK, ErrorCode
from tb.control.job_units import COPIES

__all__ = ["JobRules"]

_NONE = {"code": 0, "cluster": 0, "number": 0}
_ABORTED, _WATCHDOG = ErrorCode.ABORTED.value, ErrorCode.WATCHDOG.value
_ALL = (1 << len(REGIONS)) - 1
_STATUS = ("busy", "loading", "halted", "stops", "loaded", "failed", "unwritten")
_KEPT = ("ring", "completions", "ring_bits")


def _port_code(given, reply):
    """The port's first fault if it is of the same direction, else ``reply``."""
    code = given["memory_fault"].get("code", 0)
    return code if ErrorCode(code).name.split("_")[0] == reply.name.split("_")[0] else reply.value


class JobRules:
    """An account of what the units have sent and of what the control has accepted, and what follows for its outputs.

    What is in flight, and whether the queue runs, is known from the transfers; the cycles of the watchdog alone are
    bounded, not predicted.

    Parameters
    ----------
    clusters, nodes
        Their numbers; clusters are the first nodes.
    taken
        Descriptors that were taken before.
    """

    def __init__(self, *, clusters: int, nodes: int, taken: int = 0):
        self._nodes, self._cycle, self._taken = nodes, 0, taken
        self._live, self._drains, self._far, self._resuming, self._copies = True, False, False, False, False
        # Of each cluster [tag, has begun], and when its oldest section was sent or the one before it was collected.
        self._sections, self._since = [deque() for _ in range(clusters)], [0] * clusters
        self._load, self._loaded, self._aborted, self._tail = None, False, deque(), 0
        self._error, self._polled, self._unwritten, self._resets, self._drained = dict(_NONE), (), 0, False, False
        self._enable = self._pending = self._halted = 0
        self._completed, self._kept, self._stopped, self._memory_busy = 0, dict.fromkeys(_KEPT, 0), False, 0
        self._watchdog, self._free_error, self._late = 0, True, deque([(set(), False)] * 2, maxlen=2)

    def check(self, given: dict, said: dict) -> None:
        """What the control says in a cycle in which it is given this."""
        self._given, self._said = given, said
        command = given["i_command"]
        self._command = None if command is None else next((bit for bit in (1, 2, 4) if command & bit), 0)
        self._enters_stop()
        self._outputs()
        self._errors_and_resets()
        self._late.append(self._overdue())
        self._transfers()
        self._after()

    def _enters_stop(self):
        """A reset has a cause, and lasts until main memory has answered."""
        stops, error = self._said["stops"], self._said["error"]
        overdue, is_load = self._late[0]
        if self._stopped:
            assert stops == self._memory_busy, "units are in reset until main memory has answered"
        elif self._resets or self._drained:
            assert stops, "a cause resets in the next cycle"
        else:
            assert not stops or overdue or is_load, "a reset has a cause"
        expected = next((one for one in self._candidates if one["code"]), _NONE) if self._free_error else self._error
        late = error["code"] == _WATCHDOG and self._free_error and error["number"] == 0 and error["cluster"] in (
            {0} if is_load else overdue)
        assert late or error == expected, "the first error stays, and of several the first of the list"
        self._error = error
        if stops and not self._stopped and self._live:
            self._blame(late and is_load)
        if stops:
            self._live = self._drains = False
            self._tail = 0

    _candidates = ()

    def _overdue(self):
        """Clusters whose oldest section has had its cycles, and whether the load has; a reset comes 2 cycles later."""
        limit, load, cycle = self._given["watchdog"], self._load, self._cycle
        return {k for k, (since, sections) in enumerate(zip(self._since, self._sections, strict=True))
                if limit and sections and cycle - since > limit + self._nodes}, bool(
                    limit and load and cycle - load["begin"] > limit)

    def _blame(self, at_load):
        """The records of what was in flight, by cluster and in the order of the queue."""
        error = self._error
        is_known = self._free_error and (error["code"] == _WATCHDOG or error in self._culprits)
        culprit = error if is_known else next(iter(self._culprits), _NONE)
        self._is_vague = bool(self._watchdog and not is_known)
        for k, sections in enumerate(self._sections):
            begun = [tag for tag, has_begun in sections if has_begun]
            blamed = [tag for tag, _ in sections][:1] if culprit["code"] == _WATCHDOG else begun[-1:]
            is_own = culprit["code"] and culprit["cluster"] == k and not at_load
            for tag, _ in sections:
                code, number = (culprit["code"], culprit["number"]) if is_own and tag in blamed else (_ABORTED, 0)
                self._aborted.append({"tag": tag, "code": code, "cluster": k, "number": number, "begin": 0, "end": 0})
        if self._load:
            code = _WATCHDOG if at_load else _ABORTED
            self._aborted.append(self._load["record"] or {
                "tag": self._load["tag"], "code": code, "cluster": NO_CLUSTER, "number": 0, "begin": 0, "end": 0})
        self._sections, self._load = [deque() for _ in self._sections], None

    def _outputs(self):
        given, said, load = self._given, self._said, self._load
        stops, live, waits = said["stops"], self._live, any(self._sections)
        idle = not (waits or self._aborted or load or given["dispatches"]) and given["empty"]
        even = self._taken == given["doorbell"]
        reads = bool(load) and load["record"] is None and not stops
        self._runs = live and not self._drains
        self._can_resume = not (live or stops or self._resuming)
        offered = load["given"] if reads and load["is_offered"] else None
        halted = not (live or self._resuming)
        expected = {
            "taken": self._taken, "cycles": self._cycle, "enable": self._runs and not load,
            "i_load": self._runs and not load and not waits, "loaded": self._loaded, "o_load": offered,
            "clear": stops or self._command == 2 or offered is not None,
            "retry": self._command == 4 and self._can_resume,
            "interrupt_value": [self._enable, self._pending], "irq": self._enable & self._pending,
            "kept": self._kept,
            "status": dict(zip(_STATUS, (
                not idle or stops or self._resuming or (live and not even), reads, halted, stops,
                self._loaded, self._error["code"] != 0, given["unwritten"]), strict=True))}
        for name, value in expected.items():
            assert said[name] == value, f"{name} must be {value}"
        section = self._sections[given["source"]]
        assert not (live and section) or said["tag"] == section[0][0], "the tag of the oldest section"
        self._records(stops)
        self._takes(idle, even)

    def _records(self, stops):
        said, given, record = self._said, self._given, self._said["o_record"]
        if self._live:
            over = self._load and self._load["record"]
            assert record == (over or given["i_refused"]), "the record of a load comes before that of a refusal"
            assert said["i_refused"] == (not over and given["o_record"])
        elif record:
            expected = self._aborted[0]
            if self._is_vague and record["code"] == _WATCHDOG:
                expected, self._is_vague = expected | {"code": record["code"], "number": 0}, False
            assert not stops
            assert record == expected, "what was in flight, in its order, with the code of the one to blame"
        else:
            assert self._tail <= self._nodes or not self._aborted, "each descriptor has its record"

    def _takes(self, idle, even):
        said, given = self._said, self._given
        if given["memory_busy"] or said["stops"] or (self._live and self._drains):
            assert not said["takes"]
        elif self._live:
            assert said["takes"] == (idle and even), "registers are taken over while nothing is in flight"
        elif self._aborted:
            assert said["takes"] == (given["unwritten"] and not self._resuming), "the ring of lost records may move"
        else:
            may = not self._load and (given["empty"] or given["unwritten"])
            assert said["takes"] == may if self._tail > self._nodes + 1 else may or not said["takes"]

    def _errors_and_resets(self):
        """What of this cycle resets, and what becomes `error` in the next one, in their order."""
        given, load, command = self._given, self._load, self._command
        over = given["load_over"]
        fails = given["unwritten"] and not self._unwritten
        ring = self._runs and given["unread"]
        entry = self._taken % (1 << self._kept["ring_bits"])

        def one(code, number=0):
            return {"code": code, "cluster": 0, "number": number}

        self._candidates = [
            one(_port_code(given, ErrorCode.WRITE_REPLY) if fails else 0, given["address"]),
            one(self._over_code(over) if over and load and load["resumes"] and not self._said["stops"] else 0,
                over and over.get("address", 0)),
            *self._polled, one(_port_code(given, ErrorCode.READ_REPLY) if ring else 0,
                               self._kept["ring"] + entry * DESCRIPTOR.dtype.itemsize),
            one(ErrorCode.RING.value if self._runs and self._far else 0, given["doorbell"]),
            one(ErrorCode.COMMAND.value if command == 0 or (command == 4 and not self._can_resume) else 0)]
        self._resets = not self._said["stops"] and bool(command == 1 or fails or self._polled)
        self._culprits = self._polled
        self._drained = self._live and self._drains and not (
            any(self._sections) or load or given["dispatches"]) and given["empty"]
        self._free_error = not self._error["code"] or command == 2
        self._next_drains = self._drains or (self._runs and (given["unread"] or self._far))

    def _over_code(self, over):
        code = over.get("code", 0)
        return _port_code(self._given, ErrorCode.READ_REPLY) if code == ErrorCode.READ_REPLY.value else code

    def _transfers(self):
        given, said, live = self._given, self._said, self._live
        if live:
            for k, sections in enumerate(self._sections):
                if given["begins"] >> k & 1:
                    next(one for one in sections if not one[1])[1] = True
            sent, collected = given["i_sent"], given["i_collected"]
            if sent and not self._sections[sent["cluster"]]:
                self._since[sent["cluster"]] = self._cycle
            if collected is not None:
                self._sections[collected].popleft()
                self._since[collected] = self._cycle
            if sent:
                self._sections[sent["cluster"]].append([sent["tag"], False])
                self._taken += 1
            self._taken += bool(given["i_refused"] and said["i_refused"])
        elif said["o_record"] and given["o_record"]:
            self._aborted.popleft()
            self._tail = 0
        self._load_goes_on()
        self._taken %= 1 << 32

    def _load_goes_on(self):
        given, said, load, over = self._given, self._said, self._load, self._given["load_over"]
        active = not said["stops"]
        if load is None:
            if given["i_load"] and said["i_load"]:
                self._begin_load(given["i_load"], is_resume=False)
            elif said["takes"] and self._resuming and not self._resets:
                self._begin_load({"image": given["image"], "regions": _ALL, "copies": self._copies}, is_resume=True)
        elif load["record"]:
            if self._live and given["o_record"]:
                self._load = None
        elif over is not None and active:
            code = self._over_code(over)
            complete = load["given"]["regions"] & LOADED_REGIONS == LOADED_REGIONS
            self._loaded = not code and (self._loaded or complete)
            load["record"] = {"tag": load["tag"], "code": code, "cluster": NO_CLUSTER,
                              "number": over.get("address", 0), "begin": load["begin"], "end": self._cycle}
            if load["resumes"]:
                self._load, self._resuming, self._live = None, False, not code
        elif given["o_load"] and said["o_load"]:
            load["is_offered"] = False

    def _begin_load(self, given, *, is_resume):
        self._load = {"given": {name: int(given[name]) for name in ("image", "regions", "copies")},
                      "tag": given.get("tag"), "record": None, "is_offered": True, "begin": self._cycle,
                      "resumes": is_resume}
        self._taken += not is_resume

    def _after(self):
        """What the next cycle must know of this one."""
        given, said = self._given, self._said
        limit = self._watchdog = given["watchdog"]
        if self._live and limit:
            for since, sections in zip(self._since, self._sections, strict=True):
                assert not sections or self._cycle - since <= limit + 3 * self._nodes, "a section ends in time"
            load = self._load
            assert not load or load["record"] or self._cycle - load["begin"] <= limit + 2, "a load ends in time"
        if said["stops"]:
            # A load that is left is that of a resume.
            self._resuming, self._loaded, self._load = False, False, None
        if said["retry"]:
            self._resuming, self._copies = True, bool(given["i_command"] & COPIES)
        self._far = self._runs and (given["doorbell"] - said["taken"]) % (1 << 32) > 1 << self._kept["ring_bits"]
        self._drains = self._next_drains and self._live
        number = self._cycle % self._nodes
        fault, network = dict(enumerate(given["clusters"])).get(number, {}), given["networks"][number]
        found = []
        if fault.get("code") == ErrorCode.PATH_TIMEOUT.value:
            found.append({"code": fault["code"], "cluster": number, "number": fault["number"]})
        if network:
            found.append({"code": network + NETWORK, "cluster": number, "number": 0})
        self._polled = () if said["stops"] else tuple(found)
        if said["takes"]:
            self._kept = {name: given[name] for name in _KEPT}
        write, halted = given["i_interrupt"], said["status"]["halted"]
        if write is not None:
            self._enable, self._pending = write & 1, self._pending and not write & 2
        self._pending = int(self._pending or given["completed"] != self._completed or (halted and not self._halted))
        self._completed, self._halted, self._unwritten = given["completed"], halted, given["unwritten"]
        self._stopped, self._memory_busy = said["stops"], given["memory_busy"]
        self._cycle, self._tail = (self._cycle + 1) % (1 << 32), self._tail + 1
