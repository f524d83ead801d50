"""Traces of the control of jobs: a host and units that take their time around the golden model, and the hardware."""

import random
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass, field

from amaranth.hdl import Cat, Module, Signal, Value
from amaranth.sim import Simulator

from golden.config import Config
from golden.control.job_control import COPIES, STATUS, Fault, Inputs, JobControl, Load, Outputs, Record, Registers
from golden.jobs.load_regions import LOADED_REGIONS
from hw.control import job_control as hardware
from hw.registers.error_code import NETWORK, ErrorCode
from tb.lib.payload import pack, unpack

__all__ = ["Environment", "Plan", "TraceBench", "trace"]

NUMBERS = {one.name: one.value for one in ErrorCode}
CODES = {number: name for name, number in NUMBERS.items()}
IN_FLIGHT = 3
# Of the port; which one is a matter of the seed.
WRITE_FAULTS = ("WRITE_TIMEOUT", "WRITE_PROTOCOL", "WRITE_OUTSIDE")


@dataclass(frozen=True, kw_only=True)
class Plan:
    """What happens around the control.

    Parameters
    ----------
    nodes, seed, cycles
        Clusters; of all that is drawn; cycles of the trace.
    kinds
        Of each descriptor: ``section``, ``load``, ``refused`` or ``unread``.
    ring_bits, watchdog
        Registers.
    events
        By cycle what happens: ``stop``, ``clear``, ``resume``, ``none``, ``interrupt``; ``far``: a doorbell too far;
        ``unwritten``: the completion writer fails; ``timeout``, ``network``, ``local``: faults of a drawn cluster;
        ``timeout network``, ``stop far``: both at once.
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
    kinds: tuple[str, ...] = ("load", *("section",) * 12)
    ring_bits: int = 3
    watchdog: int = 0
    events: dict[int, str] = field(default_factory=dict)
    slowest: int = 20
    bad_loads: int = 0
    resumes: bool = True
    busiest: int = 6


class Environment:
    """The host and all units but the control; what they do depends on its outputs of earlier cycles alone.

    Members
    -------
    taken, completed
        Tags of the descriptors that were taken, and of the completion records, by the units' own account.
    records
        Records with their code.
    """

    def __init__(self, plan: Plan):
        self._plan, self._draw = plan, random.Random(plan.seed)
        self.taken, self.completed, self.records = [], [], []
        # The writer and the host are not reset.
        self._held, self._written, self._failed, self._collecting = deque(), 0, False, None
        self._doorbell, self._loads, self._wait, self._extra = 0, 0, 0, 0
        self._first, self._halted_for, self._repaired = None, 0, set()
        self._reset(0)

    def _reset(self, taken):
        self._next, self._phase, self._left, self._offered = taken, "idle", 0, None
        nodes = self._plan.nodes
        # Of each cluster the sections in flight: the state and the cycles to its end.
        self._sections = [deque() for _ in range(nodes)]
        self._load_left, self._faults, self._networks = None, [Fault()] * nodes, [Fault()] * nodes
        self._memory = Fault()

    def give(self, cycle: int, values: Outputs | None) -> Inputs:
        """Inputs of a cycle, given the outputs of the one before."""
        draw, plan, event = self._draw, self._plan, self._plan.events.get(cycle)
        commands = {"stop": 1, "clear": 2, "resume": 4, "none": 0, "stop far": 1}
        command, interrupt = commands.get(event), None
        self._is_busy = values is not None and values.status["busy"]
        if event == "interrupt":
            interrupt = draw.randrange(4)
        self._host(values)
        if command is None and self._first is not None and event is None:
            command, self._first = self._first, None
        if command is not None and cycle % 2:
            # Of a resume alone it has an effect.
            command |= 1 << COPIES
        self._fault(event)
        begins = self._clusters()
        self._dispatch(values)
        self._collect()
        if event == "unwritten":
            self._failed = True
        self._given = Inputs(
            command=command, interrupt=interrupt, begins=begins, sent=self._sent,
            load=self._offered if isinstance(self._offered, Load) else None,
            refusal=self._offered if isinstance(self._offered, Record) else None,
            unread=self._phase == "unread", dispatches=self._phase in ("sending", "refused"),
            can_load=self._load_left is None and draw.random() < 0.8,
            load_over=self._over(), collected=self._collected, source=self._source,
            record_taken=self._collecting is None and not self._failed and len(self._held) < 4 and draw.random() < 0.4,
            completed=self._written, unwritten=self._failed, empty=not self._held and self._collecting is None,
            address=64 * self._written, memory_busy=self._wait > 0 or (self._is_busy and draw.random() < 0.1),
            memory=self._memory, clusters=tuple(self._faults), networks=tuple(self._networks),
            registers=Registers(ring=0x1000, completions=0x9000, ring_bits=plan.ring_bits, watchdog=plan.watchdog,
                                doorbell=(self._doorbell + self._extra) % (1 << 32), image=0x40000))
        return self._given

    def _host(self, values):
        """Descriptors are submitted while the rings have entries; a halted queue is resumed after some time."""
        draw = self._draw
        free = len(self.completed) + (1 << self._plan.ring_bits) - self._doorbell
        if values and self._doorbell < len(self._plan.kinds) and free > 0 and draw.random() < 0.3:
            self._doorbell += draw.randint(1, min(free, len(self._plan.kinds) - self._doorbell))
        self._halted_for = self._halted_for + 1 if values and values.status["halted"] and not values.stops else 0
        if self._plan.resumes and self._halted_for and self._halted_for % 9 == 4:
            self._extra, self._first = 0, 2
        elif self._plan.resumes and self._halted_for and self._halted_for % 9 == 8:
            self._first = 4

    def _fault(self, event):
        draw, k = self._draw, self._draw.randrange(self._plan.nodes)
        if event in ("timeout", "timeout network"):
            self._faults[k] = self._faults[k] or Fault("PATH_TIMEOUT", 0, draw.randrange(1 << 24))
        elif event == "local":
            self._faults[k] = self._faults[k] or Fault("PATH_CELL", 0, draw.randrange(1 << 24))
        if event in ("network", "timeout network"):
            self._networks[k] = self._networks[k] or Fault("NETWORK_ORDER")
        elif event in ("far", "stop far"):
            self._extra = (1 << self._plan.ring_bits) + len(self._plan.kinds)
        elif event in ("port reads", "port writes"):
            writes = WRITE_FAULTS[self._plan.seed % len(WRITE_FAULTS)]
            self._memory = Fault("READ_OUTSIDE" if event == "port reads" else writes, 0, 0x777)

    def _clusters(self):
        """Sections begin when the one before has been cast, and are cast and written in their order."""
        draw, begins = self._draw, set()
        for k, sections in enumerate(self._sections):
            casting = [one for one in sections if one["state"] == "cast"]
            for one in sections:
                one["left"] = max(0, one["left"] - 1)
                if one["state"] == "cast" and not one["left"] and not any(
                        other["state"] in ("written", "done") for other in sections):
                    one["state"], one["left"] = "written", draw.randint(1, self._plan.slowest)
                elif one["state"] == "written" and not one["left"]:
                    one["state"] = "done"
            waiting = next((one for one in sections if one["state"] == "slot"), None)
            if waiting and not casting and not waiting["left"]:
                waiting["state"], waiting["left"] = "cast", draw.randint(1, self._plan.slowest)
                begins.add(k)
        return frozenset(begins)

    def _dispatch(self, values):
        """One descriptor after the other."""
        draw, self._sent = self._draw, None
        if self._phase == "idle" and values and values.enable and self._next < self._doorbell and draw.random() < 0.7:
            kind = self._plan.kinds[self._next]
            if kind == "unread" and self._next not in self._repaired:
                self._repaired.add(self._next)
                self._phase = "unread"
            elif kind == "load":
                self._phase = "load"
                self._offered = Load(tag=self._tag, image=0x2000 + 64 * self._next, regions=LOADED_REGIONS,
                                     copies=self._next % 3 == 0)
            else:
                self._phase, self._left = "sending", draw.randint(1, 6)
        elif self._phase == "sending":
            self._left = max(0, self._left - 1)
            free = [k for k, sections in enumerate(self._sections) if len(sections) < IN_FLIGHT
                    and all(one["state"] != "slot" for one in sections)]
            if not self._left and self._plan.kinds[self._next] == "refused":
                self._phase = "refused"
                self._offered = Record(tag=self._tag, code="DESCRIPTOR", number=self._next)
            elif not self._left and free:
                self._sent = draw.choice(free), self._tag

    @property
    def _tag(self):
        return (self._next * 0x9E3779B1 + 5) % (1 << 32)

    def _over(self):
        if self._load_left is None or self._load_left > 0:
            return None
        self._loads += 1
        return Fault("READ_REPLY" if self._loads % 2 else "POINTER", 0, 0x3000) if (
            self._loads <= self._plan.bad_loads) else Fault()

    def _collect(self):
        """The completion writer: one record after the other, answered in their order."""
        draw, self._collected = self._draw, None
        done = [k for k, sections in enumerate(self._sections) if sections and sections[0]["state"] == "done"]
        if self._collecting is not None:
            if draw.random() < 0.4:
                self._collected = self._collecting
        elif done and len(self._held) < 4 and draw.random() < 0.6:
            self._collecting = draw.choice(done)
        self._source = self._collecting if self._collecting is not None else draw.randrange(self._plan.nodes)
        self._answers = bool(self._held) and not self._failed and draw.random() < 0.3

    def after(self, values: Outputs) -> None:
        """What the outputs of the cycle change."""
        given, draw = self._given, self._draw
        self._wait = max(0, self._wait - 1)
        if values.retry:
            self._failed = False
        if values.record and given.record_taken:
            self._held.append(values.record.tag)
            self.completed.append(values.record.tag)
            self.records.append(values.record)
        if values.stops:
            # Of the writer, only a record that was being collected is lost.
            self._collecting = None
            self._reset(values.taken)
            return
        if self._load_left is not None and not self._load_left:
            self._load_left = None
        elif self._load_left:
            self._load_left -= 1
        if values.load and given.can_load:
            self._load_left = draw.randint(1, self._plan.slowest)
        if given.sent:
            cluster, tag = given.sent
            self._sections[cluster].append({"tag": tag, "state": "slot", "left": draw.randint(0, 2)})
            self._go_on(tag)
        if given.load and values.takes_load:
            self._go_on(given.load.tag)
        if given.refusal and values.record is given.refusal and given.record_taken:
            self._go_on(given.refusal.tag)
        if given.collected is not None:
            section = self._sections[given.collected].popleft()
            assert values.tag == section["tag"], "the tag of the oldest section"
            self._held.append(section["tag"])
            self.completed.append(section["tag"])
            self._collecting = None
        if self._answers:
            self._held.popleft()
            self._written += 1

    def _go_on(self, tag):
        self.taken.append(tag)
        self._next, self._phase, self._offered = self._next + 1, "idle", None

    def delay(self):
        """Main memory has outstanding transactions when a reset begins."""
        self._wait = self._draw.randint(0, self._plan.busiest)


def trace(plan: Plan) -> tuple[list[tuple[Inputs, Outputs]], Environment]:
    """What the control sees and says in each cycle, and the units around it."""
    model, around, found, values = JobControl(nodes=plan.nodes), Environment(plan), [], None
    for cycle in range(plan.cycles):
        stopped = values is not None and values.stops
        given = around.give(cycle, values)
        values = model.step(given)
        found.append((given, values))
        if values.stops and not stopped:
            around.delay()
        around.after(values)
    return found, around


class TraceBench:
    """The hardware in Amaranth's simulator, for one trace after the other, each from reset.

    Parameters
    ----------
    config
        The configuration.
    """

    def __init__(self, config: Config):
        dut = self._dut = hardware.JobControl(config=config)
        self._inputs, self._outputs = _inputs(dut), _outputs(dut)
        self._given = Signal(sum(len(port) for port, _ in self._inputs))
        self._sampled = Signal(sum(map(len, self._outputs.values())))
        top = Module()
        top.submodules.dut = dut
        top.d.comb += [Cat(port for port, _ in self._inputs).eq(self._given),
                       self._sampled.eq(Cat(*self._outputs.values()))]
        self._simulator, self._values, self._trace = Simulator(top), None, None
        self._simulator.add_clock(1e-8)

    def run(self, given: Iterable[Inputs]) -> list[Outputs]:
        """What the hardware says in each cycle."""
        first, self._values, self._trace = self._values is None, [self._pack(one) for one in given], []
        if first:
            self._simulator.add_testbench(self._drive)
        else:
            self._simulator.reset()
        self._simulator.run()
        return [self._unpack(bits) for bits in self._trace]

    async def _drive(self, ctx):
        for value in self._values:
            ctx.set(self._given, value)
            *_, values = await ctx.tick().sample(self._sampled)
            self._trace.append(values)

    def _pack(self, given):
        bits = place = 0
        for port, value in self._inputs:
            bits |= (int(value(given)) & (1 << len(port)) - 1) << place
            place += len(port)
        return bits

    def _unpack(self, bits):
        values = {}
        for name, port in self._outputs.items():
            values[name], bits = bits & (1 << len(port)) - 1, bits >> len(port)
        status = {name: bool(values["status"] >> bit & 1) for bit, name in enumerate(STATUS)}
        dut, load, record = self._dut, None, None
        if values["load_valid"]:
            load = unpack(dut.o_load.payload.shape(), values["load"])
        if values["record_valid"]:
            record = unpack(dut.o_record.payload.shape(), values["record"])
            record = Record(**{**record, "code": CODES[record["code"]]})
        error = unpack(dut.error.shape(), values["error"])
        flags = ("stops", "clear", "enable", "loaded", "retry", "takes_load", "takes")
        return Outputs(
            **{name: bool(values[name]) for name in flags},
            load=load, record=record, tag=values["tag"], taken=values["taken"], status=status,
            error=Fault(CODES[error["code"]], error["cluster"], error["number"]), enabled=bool(values["interrupt"] & 1),
            pending=bool(values["interrupt"] & 2), ring=values["ring"], completions=values["completions"],
            ring_bits=values["ring_bits"])


def _inputs(dut):
    """Each input of the control with its value."""
    registers = ("ring", "completions", "ring_bits", "doorbell", "image", "watchdog")
    found = [(getattr(dut, name), lambda given, name=name: getattr(given.registers, name)) for name in registers]
    found += [(getattr(dut, name), lambda given, name=name: getattr(given, name)) for name in (
        "unread", "dispatches", "source", "completed", "empty", "unwritten", "address", "memory_busy")]

    def event(stream, value, packed):
        shape = stream.payload.shape()
        found.append((stream.valid, lambda given: value(given) is not None))
        found.append((stream.payload, lambda given: 0 if value(given) is None else pack(shape, packed(value(given)))))

    def fault(code, number, value, first=0):
        found.append((code, lambda given: max(0, NUMBERS[value(given).code] - first)))
        if number is not None:
            found.append((number, lambda given: value(given).number))

    event(dut.i_command, lambda given: given.command, lambda value: value)
    event(dut.i_interrupt, lambda given: given.interrupt, lambda value: value)
    event(dut.i_sent, lambda given: given.sent, lambda sent: dict(zip(("cluster", "tag"), sent, strict=True)))
    event(dut.i_load, lambda given: given.load, vars)
    event(dut.i_refused, lambda given: given.refusal, lambda one: {**vars(one), "code": NUMBERS[one.code]})
    event(dut.i_collected, lambda given: given.collected, lambda value: value)
    event(dut.load_over, lambda given: given.load_over,
          lambda one: {"code": NUMBERS[one.code], "address": one.number})
    found += [(dut.o_load.ready, lambda given: given.can_load), (dut.o_record.ready, lambda given: given.record_taken),
              (dut.begins, lambda given: sum(1 << k for k in given.begins))]
    fault(dut.memory_fault.code, dut.memory_fault.address, lambda given: given.memory)
    for k in range(len(dut.networks)):
        fault(dut.clusters[k].code, dut.clusters[k].number, lambda given, k=k: given.clusters[k])
        fault(dut.networks[k], None, lambda given, k=k: given.networks[k], NETWORK)
    return [(Value.cast(port), value) for port, value in found]


def _outputs(dut):
    """Each output of the control by name."""
    values = {name: getattr(dut, name) for name in (
        "stops", "clear", "enable", "loaded", "retry", "takes", "tag", "taken", "status", "error")}
    values |= {name: dut.kept[name] for name in ("ring", "completions", "ring_bits")}
    values |= {"takes_load": dut.i_load.ready, "load_valid": dut.o_load.valid, "load": dut.o_load.payload,
             "record_valid": dut.o_record.valid, "record": dut.o_record.payload, "interrupt": dut.interrupt_value}
    return {name: Value.cast(port) for name, port in values.items()}
