"""What a component is given in each cycle, drawn, and what a golden model expects of all its outputs then.

A declared testbench with a method `tb.lib.bench.Bench.model` is a table of cycles, which the simulators only replay:
the model alone decides what a source does next, so the table is there before the component runs.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from random import Random
from types import SimpleNamespace

from amaranth.hdl import Cat, ClockDomain, Module, Shape, Signal, Value
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.wiring import In, Out

from hw.lib.payload import mask_of, pack, unpack
from tb.lib.ranges import ends
from tb.lib.signature import payload_shape, port_flows, ports_of, stream_of, streams_of
from tb.lib.simulator import simulator_of

__all__ = ["Cycle", "Table", "any_value", "replay"]

# The chances of an offer and of readiness in the parts of a table: first without stalls.
CHANCES = ((1, 1), (0.5, 0.5), (0.9, 0.3), (0.3, 0.9), (1, 0.6), (0.6, 1))


def any_value(shape, random: Random):
    """A payload; many numbers are at the ends of their shapes."""
    if isinstance(shape, StructLayout):
        return {name: any_value(field.shape, random) for name, field in shape}
    if isinstance(shape, ArrayLayout):
        return [any_value(shape.elem_shape, random) for _ in range(shape.length)]
    cast = Shape.cast(shape)
    return random.choice(ends(shape)) if random.random() < 0.3 else random.getrandbits(cast.width)


@dataclass(frozen=True)
class Cycle:
    """One cycle of a table: values by signal. An output is compared in the bits of its mask.

    Parameters
    ----------
    given
        By input signal.
    expected
        By output signal: bits and mask.
    resets
        It is a cycle of reset; no output is compared.
    """

    given: dict[str, int]
    expected: dict[str, tuple[int, int]]
    resets: bool = False


class Table:
    """The cycles of a declared testbench with a model.

    Parameters
    ----------
    bench, component, config
        The testbench, and what it has made.
    seed
        Of all that is drawn.

    Members
    -------
    cycles
        Of several parts, each from reset, the first one without gaps and stalls.
    inputs, outputs
        Signals and their shapes, by the names that they have in Verilog.

    Raises
    ------
    AssertionError
        The model is silent about an output, or an output that is not in the testbench's ``constant`` never changes.
    """

    def __init__(self, bench, component, config, seed: int):
        self._bench, self._config, signature = bench, config, component.signature
        self._streams, flows, shapes = streams_of(signature), port_flows(signature), ports_of(signature)
        self._ports = {flow: {name: shape for name, shape in shapes.items() if flows[name] is flow}
                       for flow in (In, Out)}
        self._shapes = {name: payload_shape(signature, name) for names in self._streams.values() for name in names}
        self._waits = {name for names in self._streams.values() for name in names
                       if not stream_of(component, name).signature.always_ready}
        self.inputs, self.outputs = dict(self._ports[In]), dict(self._ports[Out])
        for flow, ours, theirs in ((In, self.inputs, self.outputs), (Out, self.outputs, self.inputs)):
            for name in self._streams[flow]:
                ours |= {f"{name}__valid": 1, f"{name}__payload": self._shapes[name]}
                theirs |= {f"{name}__ready": 1} if name in self._waits else {}
        self._random, self.cycles = Random(seed), []
        for offers, accepts in bench.chances:
            self.cycles += [Cycle(dict.fromkeys(self.inputs, 0), {}, resets=True)] * 2
            self.cycles += self._part(offers, accepts)
        for name in self.outputs:
            met = {cycle.expected[name][0] for cycle in self.cycles if name in cycle.expected}
            assert met, f"the model says nothing of {name}"
            varies = len(met) > 1 or not _width(self.outputs[name]) or name in bench.constant
            assert varies, f"{name} is always {met.pop()}"

    def _part(self, offers, accepts) -> Iterator[Cycle]:
        """Cycles with some chances of offers and of readiness."""
        random, bench = self._random, self._bench
        model = bench.model(self._config)
        next(model)
        items = {name: bench.items(name, self._shapes[name], random) for name in self._streams[In]}
        given = SimpleNamespace(**dict.fromkeys(self._streams[In]))
        for _ in range(bench.span):
            for name, shape in self._ports[In].items():
                setattr(given, name, any_value(shape, random))
            for name in self._streams[In]:
                if getattr(given, name) is None and random.random() < offers:
                    setattr(given, name, next(items[name], None))
            for name in self._streams[Out]:
                setattr(given, name, name not in self._waits or random.random() < accepts)
            bench.drive(given, random)
            said = model.send(given)
            yield Cycle(self._inputs(given), self._outputs(said))
            for name in self._streams[In]:
                if name not in self._waits or said[name]:
                    setattr(given, name, None)

    def _inputs(self, given):
        found = {name: pack(shape, getattr(given, name)) for name, shape in self._ports[In].items()}
        for name in self._streams[In]:
            item, shape = getattr(given, name), self._shapes[name]
            # Without ``valid`` the payload has no meaning, and must have no effect.
            found[f"{name}__valid"] = int(item is not None)
            found[f"{name}__payload"] = self._random.getrandbits(max(1, _width(shape))) & (
                (1 << _width(shape)) - 1) if item is None else pack(shape, item)
        return found | {f"{name}__ready": int(getattr(given, name))
                        for name in self._streams[Out] if name in self._waits}

    def _outputs(self, said):
        found = {f"{name}__ready": (int(bool(said[name])), 1) for name in self._streams[In]
                 if name in self._waits and said[name] is not None}
        for name in self._streams[Out]:
            item, shape = said[name], self._shapes[name]
            found[f"{name}__valid"] = (int(item is not None), 1)
            if item is not None:
                mask = mask_of(shape, item)
                found[f"{name}__payload"] = pack(shape, item) & mask, mask
        for name, shape in self._ports[Out].items():
            if said[name] is not None:
                mask = mask_of(shape, said[name])
                found[name] = pack(shape, said[name]) & mask, mask
        return found

    def compare(self, number: int, name: str, came: int) -> None:
        """Fail if an output's bits are not those that are expected in a cycle."""
        bits, mask = self.cycles[number].expected.get(name, (0, 0))
        shape = self.outputs[name]
        assert came & mask == bits, (
            f"cycle {number}: {name} is {unpack(shape, came & mask)}, not {unpack(shape, bits)}")


def _width(shape):
    return Shape.cast(shape).width


def replay(component, table: Table) -> None:
    """Compare all outputs of a component in all cycles of a table, in Amaranth's own simulator.

    Raises
    ------
    AssertionError
        Says which output differs first.
    """
    # What is given and what is seen are one signal each: the simulator is slow in accesses from outside.
    top, domain = Module(), ClockDomain("sync")
    top.domains.sync, top.submodules.dut = domain, component
    given, seen = (Signal(sum(map(_width, shapes.values())) + more)
                   for shapes, more in ((table.inputs, 1), (table.outputs, 0)))
    driven = [_signal(component, name) for name in table.inputs]
    top.d.comb += [Cat(*driven, domain.rst).eq(given),
                   seen.eq(Cat(_signal(component, name) for name in table.outputs))]
    faults = []

    def joined(shapes, values):
        bits = shift = 0
        for name, shape in shapes.items():
            bits |= values.get(name, 0) << shift
            shift += _width(shape)
        return bits, shift

    async def bench(ctx):
        for number, cycle in enumerate(table.cycles):
            bits, shift = joined(table.inputs, cycle.given)
            ctx.set(given, bits | cycle.resets << shift)
            *_, came = await ctx.tick().sample(seen)
            expected, _ = joined(table.outputs, {name: bits for name, (bits, _) in cycle.expected.items()})
            mask, _ = joined(table.outputs, {name: mask for name, (_, mask) in cycle.expected.items()})
            if came & mask != expected:
                faults.append((number, came))
                return

    simulator_of(top, bench).run()
    for number, came in faults:
        for name, shape in table.outputs.items():
            table.compare(number, name, came & (1 << _width(shape)) - 1)
            came >>= _width(shape)


def _signal(component, name):
    """The signal of a name in Verilog."""
    stream, _, wire = name.rpartition("__")
    return Value.cast(getattr(stream_of(component, stream), wire) if stream else getattr(component, name))
