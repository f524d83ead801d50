"""Faults that meet each other in a job: two or three of them, at any time and at any distance, and what registers.md
says of the codes.
"""

import random
from dataclasses import dataclass

import numpy as np

from golden.engine.jobs.completion import NO_CLUSTER
from golden.engine.jobs.job import plan_job
from hw.registers.error_code import ErrorCode
from radiosity.flow.simulator.simulated_port import complete
from tb.lib.configurations import config_of
from tb.system.checked_machine import count_used_entries
from tb.system.job_machine import BASE, SMALL, JobMachine
from tb.system.scenes import phase

__all__ = ["FaultCampaign"]

SILENCES = "mute_reads", "mute_writes"
ENDINGS = *SILENCES, "refused"
# What meets what: an error another one, a silence, or a load; a stop any fault.
PAIRS = {"error x error": (("refused",), ("refused",)), "error x silence": (("refused",), SILENCES),
         "error x load": (("refused",), ENDINGS), "stop x fault": (("stop",), ENDINGS)}
THIRDS = *ENDINGS, "stop", "watchdog"
# By fault the codes of registers.md that a load, a section, and the queue may end with. After a time-out of reads all
# reads end as errors, and after one of writes all writes.
CODES = {
    "refused": (("READ_REPLY",), ("READ_REPLY", "WRITE_REPLY", "PATH_BUS"), ("READ_REPLY", "WRITE_REPLY")),
    "mute_reads": (("READ_REPLY", "READ_TIMEOUT"), ("READ_REPLY", "PATH_BUS", "PATH_TIMEOUT"),
                   ("READ_REPLY", "READ_TIMEOUT", "PATH_TIMEOUT")),
    "mute_writes": ((), ("WRITE_REPLY",), ("WRITE_REPLY", "WRITE_TIMEOUT")),
    "watchdog": (("WATCHDOG",), ("WATCHDOG",), ("WATCHDOG",)), "stop": ((), (), ())}
# Codes of a culprit: the reset that they end in gives what else is in flight ABORTED.
CULPRITS = ErrorCode.PATH_TIMEOUT, ErrorCode.WATCHDOG
# Cycles until a machine that has ended has returned all credits, and those between samples of the entries in use.
QUIET, SAMPLE = 400, 150


@dataclass(frozen=True, kw_only=True)
class _End:
    """What a queue has come to.

    Parameters
    ----------
    before, after
        Records of what was taken until the queue halted, if it has, and of what a resume has let it take.
    error, halted
        The register ``error``, and whether the queue has halted.
    """

    before: list
    after: list
    error: ErrorCode
    halted: bool


class FaultCampaign:
    """A machine and a job of two phases, each with a load and two frusta.

    Parameters
    ----------
    clusters
        Of the machine.
    changes
        Of its configuration, beside `SMALL`.

    Members
    -------
    most_used
        Most entries in use that a sample has met.
    ended
        Jobs in which something has ended with an error.
    """

    def __init__(self, clusters: int, **changes):
        self._clusters, self._completed, self.most_used, self.ended = clusters, 0, 0, 0
        config = config_of(SMALL | {"noc.columns": clusters} | changes)
        phases = [phase("cornell", config, cell=0.5, rays=(32, 8), points=(5, 6), sets=sets, clusters=clusters)
                  for sets in ("scheduled", [()] * clusters)]
        self._machine = JobMachine(plan_job(phases, config, base=BASE), latency=8, spread=8, shuffles=True)
        records = self._machine.right()
        begin = int(records["begin"].min())
        self._cycles = int(records["end"].max()) - begin
        self._loads = [(int(one["begin"]) - begin, int(one["end"]) - begin) for one in records
                       if one["cluster"] == NO_CLUSTER]

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._machine.port.close()

    def run(self, draw: random.Random) -> None:
        """Draw faults for a job: it ends, with codes in their order and all entries free, and the next job is exact."""
        name = draw.choice(sorted(PAIRS))
        kinds = [draw.choice(some) for some in PAIRS[name]]
        if draw.random() < 0.5:
            kinds.append(draw.choice(THIRDS))
        # An error that is to meet a load comes first.
        if not (is_at_load := name == "error x load"):
            draw.shuffle(kinds)
        machine = self._machine
        machine.begin()
        machine(machine.host.write("watchdog", 0))
        taken, self._completed = (machine(machine.host.read(name)) for name in ("taken", "completed"))
        machine.submit()
        machine(machine.port.wait(self._begin(draw, is_at_load=is_at_load)))
        memory = {}
        for kind in kinds:
            memory = self._inject(kind, draw, memory)
            self._wait(draw.randrange(1, draw.choice((2, 20, 200, self._cycles // 2))))
        # A silence that lasts is a time-out.
        self._wait(draw.choice((1, 1 << 12)))
        end = self._settle(taken)
        errors = check_codes(end, kinds, loads=[tag for tag, one in enumerate(machine.job.sections) if not one])
        machine.check(np.array(end.before + end.after), errors)
        self._check_entries(f"after {kinds}")
        machine.right()
        self._check_entries("after the next job")
        self.ended += bool(errors)

    def _begin(self, draw, *, is_at_load):
        """The cycle of the first fault."""
        if not is_at_load:
            return draw.randrange(self._cycles)
        begin, end = draw.choice(self._loads)
        return draw.randrange(max(0, begin - 50), end + 50)

    def _inject(self, kind, draw, memory):
        """One more fault; returns those that memory has now. Those of before stay, or end where it begins."""
        machine = self._machine
        memory = {} if draw.random() < 0.3 else dict(memory)
        if kind == "refused":
            memory |= {"first": self._address(draw), "size": draw.choice((1, 64, 4096))}
        elif kind in SILENCES:
            memory[kind] = True
        elif kind == "watchdog":
            machine(machine.host.write("watchdog", draw.randrange(1, 1000)))
        else:
            machine(machine.host.command("stop"))
        machine.port.fault(**memory)
        return memory

    def _address(self, draw):
        """Of any byte, or of what a cast or the queue accesses."""
        job, section = self._machine.job, draw.choice(self._machine.job.descriptors[1:3])
        one = draw.choice(job.phases)
        return draw.choice((
            lambda: draw.randrange(job.base, job.end), lambda: job.entry(self._completed + draw.randrange(6)),
            lambda: job.completion(self._completed + draw.randrange(6)),
            lambda: int(section[draw.choice(("hits", "sums_address", "near_cells"))]),
            lambda: one.address + one.image.offsets["cells"] + draw.randrange(one.image["cells"].nbytes),
            lambda: one.address + one.image.offsets["patches"] + draw.randrange(one.image["patches"].nbytes)))()

    def _wait(self, cycles):
        """So many cycles, with samples of the entries in use between them."""
        complete(self._machine.port.wait(min(cycles, SAMPLE)))
        self.most_used = max(self.most_used, count_used_entries(self._machine.port, self._clusters))
        complete(self._machine.port.wait(cycles - min(cycles, SAMPLE)))

    def _settle(self, taken):
        """With a memory that is sound again: until the queue has nothing to do, or has halted; then to the end of the
        job. So many descriptors were taken before it.
        """
        machine, host = self._machine, self._machine.host
        machine.port.fault()
        complete(machine.port.wait(2000))
        records = machine.ended()
        error, halted = ErrorCode(machine(host.read("error"))), machine(host.status())["halted"]
        taken = machine(host.read("taken")) - taken
        machine(host.write("watchdog", 0))
        if halted:
            # Those that memory has refused to write come first.
            records += machine.resumed(attempts=20)
            status = machine(host.status())
            assert not status["halted"] | status["failed"], f"the resumed queue has {status}"
        return _End(before=records[:taken], after=records[taken:], error=error, halted=bool(halted))

    def _check_entries(self, when):
        complete(self._machine.port.wait(QUIET))
        used = count_used_entries(self._machine.port, self._clusters)
        assert not used, f"{used} entries are in use {when}"


def check_codes(end, kinds, *, loads) -> dict[int, ErrorCode]:
    """The codes by tag of a job with such faults and loads, in the order that registers.md and job-format.md state:

    * each has a cause;
    * a queue halts with an error, or for a stop, and else it does not;
    * a load that fails loses all tables: sections complete with NOT_LOADED until a resume;
    * what a reset has ended comes last: of clusters in their order, then a load; one of them may be the culprit, whose
      code is that of ``error`` unless an error of the queue came before.
    """
    load_codes, section_codes, queue_codes = ({code for kind in kinds for code in CODES[kind][k]} for k in range(3))
    assert end.error.name in queue_codes | {"NONE"}, f"the queue halts with {end.error.name}"
    assert end.halted or end.error is ErrorCode.NONE, f"{end.error.name} does not halt the queue"
    assert not end.halted or end.error is not ErrorCode.NONE or "stop" in kinds, "the queue halts without an error"
    codes = [ErrorCode(int(one["error"])) for one in end.before + end.after]
    # What a reset has ended.
    last = sum(code is ErrorCode.ABORTED or code in CULPRITS for code in codes)
    first = len(end.before) - last
    assert all(code is ErrorCode.ABORTED or code in CULPRITS for code in codes[first:len(end.before)]), (
        "what a reset has ended is not what comes last")
    assert end.halted or not last, "a reset without a halt"
    culprits = [code for code in codes if code in CULPRITS]
    assert len(culprits) <= 1, "several culprits of a reset"
    assert all(code.name in section_codes | load_codes for code in culprits), f"{kinds} give {culprits}"
    assert all(end.error is code or end.error.name.startswith(("READ_", "WRITE_")) for code in culprits)
    order = [int(one["cluster"]) for one in end.before[first:]] if last else []
    assert order == sorted(order), "what a reset has ended is in another order than that of the clusters"
    # After a resume all tables are loaded.
    for records, loaded in ((end.before[:first], False), (end.after, True)):
        for record in records:
            code, tag = ErrorCode(int(record["error"])), int(record["tag"])
            allowed = {"NONE"} | (load_codes if tag in loads else section_codes)
            if tag in loads:
                # The second load is of what has changed.
                loaded = code is ErrorCode.NONE and (loaded or tag == loads[0])
            elif not loaded:
                # Near cells are read before.
                allowed = allowed & {"READ_REPLY"} | {"NOT_LOADED"}
            assert code.name in allowed, f"{kinds} give {code.name}, tables are {'' if loaded else 'not '}loaded"
    return {int(one["tag"]): code for one, code in zip(end.before + end.after, codes, strict=True)
            if code is not ErrorCode.NONE}
