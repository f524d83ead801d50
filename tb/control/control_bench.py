"""`JobControl` in Amaranth's simulator, beside its rules."""

from amaranth.hdl import Cat, Module, Shape, Signal, Value
from amaranth.lib.wiring import In

from golden.engine.config import Config
from hw.control.job_control import JobControl
from hw.lib.payload import pack, unpack
from hw.registers.engine_registers import register
from tb.control.job_rules import JobRules
from tb.control.job_units import quiet
from tb.lib.simulator import simulator_of

__all__ = ["ControlBench", "Script"]


class Script:
    """Units that do what is written down.

    Parameters
    ----------
    clusters, patch_nodes
        Their numbers.
    events
        By cycle the inputs that change, see `quiet`: streams for that cycle, others from it on.
    submitted
        The doorbell after the first cycle.
    """

    def __init__(self, clusters: int, events: dict[int, dict], *, patch_nodes: int = 0, submitted: int = 6):
        self._events = {**events, 1: {"doorbell": submitted} | events.get(1, {})}
        self._state = quiet(clusters, patch_nodes)

    def give(self, cycle: int, values: dict | None) -> dict:
        """The inputs of a cycle."""
        changes = self._events.get(cycle, {})
        self._state |= {name: value for name, value in changes.items() if self._state[name] is not None}
        return self._state | changes

    def after(self, values: dict) -> None:
        """Nothing depends on what the control says."""

    def is_over(self, cycle: int) -> bool:
        """The run takes all of its cycles."""
        return False


class ControlBench:
    """The hardware in one run after the other, each from reset, with `JobRules` checked in each cycle.

    Parameters
    ----------
    config
        The configuration.
    taken
        The register after reset, to count from shortly before it wraps.
    """

    def __init__(self, config: Config, *, taken: int = 0):
        self._noc, self._taken, dut = config.noc, taken, JobControl(config=config)
        dut.taken = Signal(32, init=taken)
        # By port its shape, the shape's width, and whether it is a stream that is there or not.
        self._inputs, self._outputs, driven, seen = {}, {}, [], []
        for name, member in dut.signature.members.items():
            port, is_input = getattr(dut, name), member.flow is In
            if member.is_port:
                signals, shape, answer = [port], port.shape(), None
            else:
                signals, shape, answer = [port.valid, port.payload], port.payload.shape(), port.ready
            (self._inputs if is_input else self._outputs)[name] = shape, Shape.cast(shape).width, answer is not None
            (driven if is_input else seen).extend(map(Value.cast, signals))
            if answer is not None:
                (self._outputs if is_input else self._inputs)[name] = 1, 1, False
                (seen if is_input else driven).append(answer)
        # What is given and what is seen are one signal each: the simulator is slow in accesses from outside.
        self._given, self._seen = Signal(sum(map(len, driven))), Signal(sum(map(len, seen)))
        top = Module()
        top.submodules.dut = dut
        top.d.comb += [Cat(driven).eq(self._given), self._seen.eq(Cat(seen))]
        self._simulator, self._trace, self._run = simulator_of(top), None, None

    def run(self, units, cycles: int) -> list[tuple[dict, dict]]:
        """What the control was given and what it said, in each cycle.

        Raises
        ------
        AssertionError
            A rule is broken; with the cycle, and what was given.
        """
        is_first, self._run, self._trace, self._error = self._run is None, (units, cycles), [], None
        if is_first:
            self._simulator.add_testbench(self._drive)
        else:
            self._simulator.reset()
        self._simulator.run()
        if self._error:
            raise self._error
        return self._trace

    async def _drive(self, ctx):
        units, cycles = self._run
        rules, said = JobRules(clusters=self._noc.clusters, nodes=self._noc.nodes, taken=self._taken), None
        for cycle in range(cycles):
            given = units.give(cycle, said)
            ctx.set(self._given, self._pack(given))
            *_, seen = await ctx.tick().sample(self._seen)
            said = self._unpack(seen)
            try:
                rules.check(given, said)
            except AssertionError as error:
                # Raised here it would leave a simulator that cannot be reset.
                error.add_note(f"cycle {cycle}, in which the control is given {given} and says {said}")
                self._error = error
                return
            self._trace.append((given, said))
            units.after(said)
            if units.is_over(cycle):
                return

    def _pack(self, given):
        bits = place = 0
        for name, (shape, width, is_stream) in self._inputs.items():
            value = given[name]
            if is_stream:
                bits |= (value is not None) << place
                place += 1
            bits |= pack(shape, value) << place
            place += width
        return bits

    def _unpack(self, bits):
        said = {}
        for name, (shape, width, is_stream) in self._outputs.items():
            is_there = bits & 1 or not is_stream
            bits >>= is_stream
            said[name] = unpack(shape, bits) if is_there else None
            bits >>= width
        said["status"] = register("status").unpack(said["status"])
        said["interrupt_value"] = [said["interrupt_value"] & 1, said["interrupt_value"] >> 1]
        return said
