"""Traces of the engine's control: units that take their time around the golden model, and the hardware beside it."""

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

from amaranth.hdl import Cat, Module, Signal, Value
from amaranth.sim import Simulator

from golden.config import Config
from golden.control.engine_control import ACTIVITIES, ALL_REGIONS, EngineControl, Fault, Inputs, Outputs
from hw.control import engine_control as hardware
from hw.registers.engine_registers import register
from hw.registers.error_code import ENGINE, LIST, NETWORK, PATH, ErrorCode

__all__ = ["CLUSTER_FAULTS", "MEMORY_FAULTS", "NETWORK_FAULTS", "Plan", "TraceBench", "golden_trace"]

# Codes by the unit that reports them.
MEMORY_FAULTS = [one.name for one in ErrorCode if 0 < one.value < PATH]
CLUSTER_FAULTS = [one.name for one in ErrorCode if PATH < one.value < NETWORK or LIST < one.value < ENGINE]
CLUSTER_FAULTS.append("SECTION")
NETWORK_FAULTS = [one.name for one in ErrorCode if NETWORK < one.value < LIST]
BEGINS = {"load": "loading", "cast": "casting", "write": "writing"}
# Activities whose end is an event of its own.
ENDING = ("load", "write")
NUMBERS = {one.name: one.value for one in ErrorCode}
CODES = {number: name for name, number in NUMBERS.items()}


@dataclass(frozen=True, kw_only=True)
class Plan:
    """What happens around the control, and when.

    Parameters
    ----------
    cycles
        Cycles of the trace.
    commands
        By cycle: the value that is written to ``command``, and ``results.earlier`` from then on.
    takes
        By activity: for each start the cycles that it is busy, and the code with which it ends; the last one stays.
    watchdog
        The register.
    regions
        The register ``regions`` for each load in turn; the last one stays.
    faults
        Of each its cycle, its source (``memory``, ``clusters`` or ``networks``), its cluster, its code, and its number.
    memory_busy
        Cycles of a stop in which main memory has outstanding transactions.
    """

    cycles: int
    commands: Mapping[int, tuple[int, bool]] = field(default_factory=dict)
    takes: Mapping[str, list[tuple[int, str]]] = field(default_factory=dict)
    watchdog: int = 0
    regions: list[int] = field(default_factory=lambda: [ALL_REGIONS])
    faults: list[tuple[int, str, int, str, int]] = field(default_factory=list)
    memory_busy: int = 0


def _turn(values, number):
    return values[min(number, len(values) - 1)]


def golden_trace(plan: Plan, *, nodes: int) -> list[tuple[Inputs, Outputs]]:
    """What the control sees and says in each cycle, by the golden model and units around it."""
    model, left, started, ending = EngineControl(nodes=nodes), dict.fromkeys(ACTIVITIES, 0), Counter(), {}
    faults = {"memory": [Fault()], "clusters": [Fault()] * nodes, "networks": [Fault()] * nodes}
    is_earlier, outstanding, trace = False, 0, []
    for cycle in range(plan.cycles):
        command, is_earlier = plan.commands.get(cycle, (None, is_earlier))
        for _, source, cluster, code, number in filter(lambda one: one[0] == cycle, plan.faults):
            faults[source][cluster] = faults[source][cluster] or Fault(code, 0, number)
        given = Inputs(
            command=command, regions=_turn(plan.regions, started["load"]), watchdog=plan.watchdog,
            is_earlier=is_earlier, busy=frozenset(name for name in ACTIVITIES if left[name]),
            memory_busy=any(left.values()) or outstanding > 0,
            ends={name: Fault(ending[name], 0, 64 + cycle if ending[name] != "NONE" else 0)
                  for name in ENDING if left[name] == 1},
            memory=faults["memory"][0], clusters=tuple(faults["clusters"]), networks=tuple(faults["networks"]))
        said = model.step(given)
        trace.append((given, said))
        left = {name: 0 if said.stops else max(0, count - 1) for name, count in left.items()}
        outstanding = max(0, outstanding - 1) if said.stops else plan.memory_busy
        if said.starts:
            left[said.starts], ending[said.starts] = _turn(plan.takes.get(said.starts, [(4, "NONE")]),
                                                           started[said.starts])
            started[said.starts] += 1
        # Units forget their faults in the cycle after a clear, and network interfaces in a reset.
        for source in ("memory", "clusters") if said.clear else ():
            faults[source] = [Fault()] * len(faults[source])
        if said.stops:
            faults["networks"] = [Fault()] * nodes
    return trace


class TraceBench:
    """The hardware in Amaranth's simulator, for one trace after the other, each from reset.

    Parameters
    ----------
    config
        The configuration.
    """

    def __init__(self, config: Config):
        dut = hardware.EngineControl(config=config)
        inputs, outputs = _inputs(dut), _outputs(dut)
        self._inputs = [(len(port), value) for port, value in inputs]
        self._outputs = {name: len(port) for name, port in outputs.items()}
        # One signal each for inputs and outputs: each access from outside costs the simulator much time.
        self._given, self._said = Signal(sum(map(len, next(zip(*inputs, strict=True))))), Signal(
            sum(self._outputs.values()))
        top = Module()
        top.submodules.dut = dut
        top.d.comb += [Cat(port for port, _ in inputs).eq(self._given), self._said.eq(Cat(*outputs.values()))]
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
            *_, said = await ctx.tick().sample(self._said)
            self._trace.append(said)

    def _pack(self, given):
        bits = shift = 0
        for width, value in self._inputs:
            bits |= value(given) << shift
            shift += width
        return bits

    def _unpack(self, bits):
        said = {}
        for name, width in self._outputs.items():
            said[name], bits = bits & (1 << width) - 1, bits >> width
        return Outputs(
            starts="+".join(name for name, port in BEGINS.items() if said[port]) or None, stops=bool(said["stops"]),
            clear=bool(said["clear"]),
            status={name: bool(value) for name, value in register("status").unpack(said["status"]).items()},
            error=Fault(CODES[said["code"]], said["cluster"], said["number"]))


def _inputs(dut):
    """Each input of the control with its value."""
    def of(name):
        return lambda given: NUMBERS[name(given).code], lambda given: name(given).number

    def end(name):
        return lambda given: given.ends.get(name, Fault())

    found = [
        (dut.i_command.valid, lambda given: given.command is not None),
        (dut.i_command.payload, lambda given: given.command or 0),
        (dut.regions, lambda given: given.regions), (dut.earlier, lambda given: given.is_earlier),
        (dut.watchdog, lambda given: given.watchdog), (dut.memory_busy, lambda given: given.memory_busy),
        *((getattr(dut, f"{name}s"), lambda given, name=name: name in given.busy) for name in ACTIVITIES),
        *((getattr(dut, f"{name}_over").valid, lambda given, name=name: name in given.ends) for name in ENDING)]
    faults = [(dut.memory_fault.code, dut.memory_fault.address, lambda given: given.memory)]
    for name in ENDING:
        payload = getattr(dut, f"{name}_over").payload
        faults.append((payload.code, payload.address, end(name)))
    for k in range(len(dut.networks)):
        faults.append((dut.clusters[k].code, dut.clusters[k].number, lambda given, k=k: given.clusters[k]))
        found.append((dut.networks[k], lambda given, k=k: max(0, NUMBERS[given.networks[k].code] - NETWORK)))
    for code, number, fault in faults:
        found += zip((code, number), of(fault), strict=True)
    return [(Value.cast(port), value) for port, value in found]


def _outputs(dut):
    """Each output of the control by name."""
    said = {name: getattr(dut, name) for name in (*BEGINS.values(), "stops", "clear", "status")}
    said |= {"code": dut.error.code, "cluster": dut.error.cluster, "number": dut.error.number}
    return {name: Value.cast(port) for name, port in said.items()}
