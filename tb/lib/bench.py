"""One declaration of a testbench that runs in Amaranth's simulator, in Verilator and in Icarus.

A class of tests names the component and makes vectors::

    class TestScreening(Bench):
        component, arguments = Screening, {"tag": 9}

        def vectors(self, config):
            return Vectors(inputs={"i": [...]}, expected={"o": [...]})

The simulators run the regimes of `tb.lib.regimes`. All of them compare the cycle of every transfer with the one that
follows from the timing in the component's docstring: `Bench.predict`.
"""

import inspect
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from random import Random

import pytest
from amaranth.lib.wiring import Out

from golden.engine.config import Config
from hw.lib.payload import unpack
from tb.lib.configurations import CONFIGURATIONS, DEPTHS, config_of
from tb.lib.cycles import CHANCES, Table, any_value, replay
from tb.lib.responder import Responder
from tb.lib.runner import SIMULATORS, simulate
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.scoreboard import check
from tb.lib.seed import SEED
from tb.lib.signature import payload_shape, stream_of, streams_of
from tb.lib.stages import Gather, Stage, Trace, passage
from tb.lib.timing import documented_interval, documented_latency, documented_stages
from tb.lib.vectors import Vectors

__all__ = ["VARIANTS", "Bench", "Case", "Vectors"]

# The widths at every depth of the pipelines.
VARIANTS = [{**widths, "icu.product_registers": depth} for widths in CONFIGURATIONS.values() for depth in DEPTHS]


@dataclass(frozen=True)
class Case:
    """Vectors of a testbench that has several.

    Parameters
    ----------
    vectors
        From a configuration to vectors.
    variants
        Changes of the default configuration with which Amaranth's simulator runs them; default: the testbench's.
    simulated
        The other simulators run them too.
    timed
        Their cycles are checked.
    """

    vectors: Callable[[Config], Vectors]
    variants: Sequence[dict] | None = None
    simulated: bool = True
    timed: bool = True


class Bench:
    """A testbench of a component. Subclasses are collected by pytest and have no constructor.

    Members
    -------
    component, arguments
        The component's class, and its arguments beside the configuration, if it takes one.
    changes
        Of the default configuration.
    cases
        By name vectors, or a `Case`; default: those of the method `vectors`.
    variants
        Changes of the configuration with which Amaranth's simulator runs; none: it does not. A commit's tests have the
        one that the seed draws from those of most cases.
    simulators
        Of `test_in_the_simulator`.
    interval, per_result
        Cycles between items of the input ``i``, and how many of them make one result.
    latency
        The component's, as its docstring states it.
    formula
        Names in the docstring's formulas that are neither parameters of the configuration nor arguments.
    splits
        Each stall pattern has items of its own; otherwise each one has all of them.
    idle_limit
        A run ends after this many cycles without a transfer, and the latency.
    now, shapes
        The present vectors, and the shapes of the outputs' payloads: for methods of a subclass.
    span, chances
        Of a testbench with a `model`: cycles of each part of its table, and the parts' chances of offers and readiness.
    constant
        Signals out of it that never change.
    cycles
        Added to the cycles that the items can take: the limit of the watchdog in simulators.
    """

    component: Callable
    arguments: Mapping = {}
    changes: Mapping = {}
    cases: Mapping[str, Callable[[Config], Vectors] | Case] = {}
    variants: Sequence[dict] = VARIANTS
    simulators: Sequence = SIMULATORS
    interval, per_result = 1, 1
    formula: Mapping = {}
    splits = True
    idle_limit = 4
    cycles = 10_000
    span, chances = 150, CHANCES
    constant: Collection[str] = ()
    now: Vectors
    shapes: Mapping

    # Subclasses override these.

    def vectors(self, config: Config) -> Vectors:
        """The only case's vectors."""
        raise NotImplementedError

    def drawn(self, config: Config, seed: int) -> Vectors:
        """Vectors for a pattern of stalls or for a reset; default: parts of the cases."""
        raise NotImplementedError

    # In place of vectors and stages: all outputs of each cycle.

    def model(self, config: Config) -> Iterator:
        """A golden model from reset on, a generator: it is sent what is given in a cycle, and yields the outputs then.

        Given are by name ports' values, the item that an input offers or None, and whether an output is ready. Outputs
        are in a dict: ports' values or None for any, whether an input accepts, None for either, and what an output
        offers or None.
        """
        raise NotImplementedError

    def items(self, name: str, shape, random: Random) -> Iterator:
        """What an input offers, one item after the other from reset on; None: nothing in this cycle."""
        while True:
            yield any_value(shape, random)

    def drive(self, given, random: Random) -> None:
        """Change what was drawn for a cycle. A subclass's model may keep in ``self`` what this depends on."""

    @property
    def models(self) -> bool:
        """Whether the testbench has a model."""
        return type(self).model is not Bench.model

    @property
    def draws(self) -> bool:
        """Whether the testbench can draw."""
        return type(self).drawn is not Bench.drawn

    def make(self, config: Config):
        """The component."""
        component = type(self).component
        takes_it = "config" in inspect.signature(component).parameters
        return component(**({"config": config} if takes_it else {}), **self.arguments)

    def is_over(self, given: Vectors, came: dict[str, list[int]]) -> bool:
        """Whether everything expected has come."""
        return all(len(came[name]) >= len(items) for name, items in given.expected.items())

    def check(self, given: Vectors, came: dict[str, list[int]]) -> None:
        """Compare everything that came, as bits, with what is expected."""
        for name, expected in given.expected.items():
            check(self.shapes[name], came[name], expected, what=name)

    def stages(self, component, config: Config) -> list[Stage]:
        """Between the first input and the last expected output; default: those of the docstring."""
        assert documented_interval(type(component), config, **self.names) == self.interval
        stages = documented_stages(type(component), config, **self.names)
        return [*([Gather(self.per_result)] if self.per_result > 1 else []), *stages]

    def predict(self, given: Vectors, trace: Trace, component, config: Config) -> dict[str, list[int]]:
        """The cycles of all transfers of some streams, from the trace's offers and stalls; default: of one path."""
        (first, *_), last = given.inputs, list(given.expected)[-1]
        accepted, left = passage(self.stages(component, config), trace.offered[first], trace.stalled[last])
        return {first: accepted, last: left}

    def check_cycles(self, given: Vectors, trace: Trace, component, config: Config) -> None:
        """Compare the cycle of every transfer with the predicted one."""
        predicted = self.predict(given, trace, component, config)
        wrong = [(min(came, cycle), f"{name}: item {k} of {len(expected)} is transferred in cycle {came}, not {cycle}")
                 for name, expected in predicted.items()
                 for k, (came, cycle) in enumerate(zip(trace.cycles[name], expected, strict=False)) if came != cycle]
        assert not wrong, min(wrong)[1]
        counts = {name: (len(trace.cycles[name]), len(expected)) for name, expected in predicted.items()}
        assert all(came == count for came, count in counts.values()), f"transfers, and those predicted: {counts}"

    # Subclasses use these.

    def values(self, name: str, came: Mapping[str, list[int]]) -> list:
        """What came out of a stream, as dicts."""
        return [unpack(self.shapes[name], item) for item in came[name]]

    def config(self, changes: Mapping | None = None) -> Config:
        """The testbench's configuration with other changes."""
        return config_of({**self.changes, **(changes or {})})

    def known_cases(self) -> dict[str, Case]:
        """All cases by name."""
        return {name: case if isinstance(case, Case) else Case(case)
                for name, case in (self.cases or {"vectors": self.vectors}).items()}

    def responders(self) -> list[Responder]:
        """The environment."""
        return [getattr(self, name) for name in dir(type(self)) if isinstance(getattr(type(self), name), Responder)]

    def latency(self, component, config: Config) -> int:
        """The component's, which is that of its docstring."""
        latency = documented_latency(type(component), config, **self.names)
        assert component.latency == latency
        return latency

    def stated(self, component, config: Config) -> None:
        """A component that has a latency says the same in its docstring."""
        if hasattr(component, "latency"):
            self.latency(component, config)

    @property
    def names(self) -> dict[str, int]:
        """Those of the docstring's formulas that are no parameters of the configuration."""
        return {name: value for name, value in self.arguments.items() if isinstance(value, int)} | self.formula

    @classmethod
    def pytest_generate_tests(cls, metafunc):
        """Parameters of the tests."""
        if "changes" in metafunc.fixturenames:
            every = [changes for case in cls().known_cases().values()
                     for changes in (cls.variants if case.variants is None else case.variants)]
            different = list({str(changes): changes for changes in every}.values())
            most = max(map(every.count, different), default=0)
            drawn = different and Random(f"{SEED} {cls.__qualname__}").choice(
                [changes for changes in different if every.count(changes) == most])
            metafunc.parametrize("changes", [
                pytest.param(changes, id=_name(changes), marks=[] if changes == drawn else [pytest.mark.nightly])
                for changes in different])
        if "simulator" in metafunc.fixturenames:
            metafunc.parametrize("simulator", cls.simulators)

    def test_in_amaranth(self, changes):
        """Exact results after the latency, with and without gaps and stalls."""
        config = self.config(changes)
        component = self.make(config)
        if self.models:
            self.stated(component, config)
            replay(component, Table(self, component, config, SEED))
            return
        latency = self.latency(component, config)
        bench = ScheduleBench(component, idle_limit=latency + self.interval * self.per_result + self.idle_limit + 16,
                              watchdog=200_000)
        for case in self.known_cases().values():
            if changes in (self.variants if case.variants is None else case.variants):
                self.in_amaranth(bench, component, case.vectors(config), config, latency, timed=case.timed)

    def in_amaranth(self, bench: ScheduleBench, component, given: Vectors, config: Config, latency: int, *,
                    timed: bool = True, seed: int = 1) -> None:
        """Half of the items come without stalls, half of them with."""
        self.now, self.shapes = given, {name: payload_shape(component.signature, name)
                                        for name in streams_of(component.signature)[Out]}
        random, waits = Random(seed), self.interval - 1
        items = {}
        for name, values in given.inputs.items():
            half = -(-len(values) // 2 // self.per_result) * self.per_result
            items[name] = [((waits if number else 2) + (random.randrange(4) if number >= half else 0), value)
                           for number, value in enumerate(values)]
            waits = 0
        can_wait = [name for name in streams_of(component.signature)[Out]
                    if not stream_of(component, name).signature.always_ready]
        stalls = {}
        for name in can_wait:
            count = len(given.expected.get(name, ()))
            stalls[name] = [0] * (count // 2) + random.choices((0, 0, 1, 3, 12), k=count - count // 2)
        bench.run(Schedule(items=items, stalls=stalls, first=given.first), *self.responders(), **given.ports)
        self.check(given, bench.came)
        if timed:
            self.check_cycles(given, bench.trace, component, config)

    def test_in_the_simulator(self, simulator):
        """All regimes."""
        self.simulate(simulator)

    def simulate(self, simulator: str = "verilator", text: Callable | None = None, **more) -> None:
        """All regimes; ``text``: from the component to its Verilog, by default as it is exported."""
        component = self.make(self.config())
        module = "tb.lib.every_cycle" if self.models else "tb.lib.regimes"
        simulate(text(component) if text else component, module, simulator=simulator,
                 bench=[type(self).__module__, type(self).__qualname__], **more)


def _name(changes):
    return ", ".join(f"{path.partition('.')[2]} {value}" for path, value in changes.items()) or "default"
