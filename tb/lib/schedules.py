"""Schedules that shrink: which items come with which gaps and stalls, drawn by Hypothesis.

A property over schedules fails with the smallest one that Hypothesis finds: few items, short stalls, small numbers::

    @SETTINGS
    @given(schedules({"i": payloads(SHAPE)}, ["o"]))
    def test_everything_comes_out(schedule):
        assert BENCH.run(schedule) == {"o": schedule.values("i")}
"""

from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from itertools import islice
from random import Random

from amaranth.hdl import Cat, ClockDomain, Const, Module, Signal, Value
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.wiring import In, Out
from hypothesis import HealthCheck, settings
from hypothesis import strategies as st

from hw.lib.payload import pack, unpack
from tb.lib.ranges import integers
from tb.lib.responder import Responder
from tb.lib.seed import IS_DRAWN
from tb.lib.signature import stream_of, streams_of
from tb.lib.simulator import simulator_of
from tb.lib.stages import Trace

__all__ = ["SETTINGS", "Schedule", "ScheduleBench", "payloads", "schedules"]

# Cycles after which a schedule must be over.
WATCHDOG = 3000
# Without a seed the same examples in every run. A simulation takes longer than what Hypothesis thinks slow.
SETTINGS = settings(derandomize=not IS_DRAWN, database=None, deadline=None, max_examples=30,
                    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large])
# None is the simplest one and the most frequent.
_CYCLES = st.sampled_from((0, 0, 0, 0, 1, 2, 3, 5, 9))


@dataclass(frozen=True, kw_only=True)
class Schedule:
    """What sources offer and when, and when sinks are ready.

    Parameters
    ----------
    items
        By input: for each item the cycles without an offer before it, and its payload. An offer stays until accepted.
    stalls
        By output: the cycles without ``ready`` before each transfer, none after the last one of the list.
    first
        By input: items without gaps that come before all others, one input after the other.
    """

    items: dict[str, list[tuple[int, object]]]
    stalls: dict[str, list[int]] = field(default_factory=dict)
    first: dict[str, list] = field(default_factory=dict)

    def values(self, name: str) -> list:
        """The payloads of an input."""
        return [value for _, value in self.items[name]]


def payloads(shape) -> st.SearchStrategy:
    """All payloads of an Amaranth shape, in the form that `pack` takes; many numbers are at their ends."""
    if isinstance(shape, StructLayout):
        return st.fixed_dictionaries({name: payloads(field.shape) for name, field in shape})
    if isinstance(shape, ArrayLayout):
        return st.lists(payloads(shape.elem_shape), min_size=shape.length, max_size=shape.length)
    return integers(shape)


def schedules(items: dict[str, st.SearchStrategy], sinks: Iterable[str], *, most: int = 14) -> st.SearchStrategy:
    """Schedules of at most ``most`` items of each input.

    Parameters
    ----------
    items
        By input: the payloads of an item.
    sinks
        Outputs that can wait.
    """
    def some(element):
        # Lists of any length are mostly short.
        return st.one_of(st.lists(element, max_size=most), st.lists(element, min_size=most // 2, max_size=most))

    return st.builds(lambda items, stalls: Schedule(items=items, stalls=stalls),
                     st.fixed_dictionaries({name: some(st.tuples(_CYCLES, of)) for name, of in items.items()}),
                     st.fixed_dictionaries({name: some(_CYCLES) for name in sinks}))


class ScheduleBench:
    """A component in Amaranth's own simulator, for one schedule after the other, each from reset; collisions of its
    memories show (`with_collisions`), and its claims are checked (`hw.lib.checks`).

    Parameters
    ----------
    component
        The component. Streams of an array are called ``NAME__0`` and so on.
    inputs, outputs
        Names of its streams; default: all of them.
    idle_limit
        The run ends after so many cycles without a transfer.
    watchdog
        Cycles after which a run must be over.
    watched
        Plain outputs that are recorded.

    Members
    -------
    trace, cycles
        The last run's offers, stalls and transfers, and the cycles of its transfers alone, by input and output.
    came
        By output what came in the last run, as bits.
    history
        By watched output its bits in each cycle.
    """

    def __init__(self, component, inputs: Iterable[str] | None = None, outputs: Iterable[str] | None = None, *,
                 idle_limit: int = 16, watchdog: int = WATCHDOG, watched: Iterable[str] = ()):
        self._component, self._idle_limit, self._watchdog = component, idle_limit, watchdog
        known = streams_of(component.signature)
        self._inputs, self._outputs = (
            {name: _Stream(component, name) for name in (known[flow] if names is None else names)}
            for flow, names in ((In, inputs), (Out, outputs)))
        self._schedule, self._ports, self._responders, self.came, self.trace = None, None, (), {}, Trace()
        self._watched, self.history = {name: Value.cast(getattr(component, name)) for name in watched}, {}
        # A component may have no clock, the bench has one. What is given and what is seen are one signal each: the
        # simulator is slow in accesses from outside.
        top = Module()
        top.domains.sync = ClockDomain()
        top.submodules.dut = component
        streams = [*self._inputs.values(), *self._outputs.values()]
        driven = [signal for one in self._inputs.values() for signal in (one.valid, one.payload)]
        driven += [one.ready for one in self._outputs.values() if not isinstance(one.ready, Const)]
        self._given = Signal(sum(map(len, driven)))
        self._seen = Signal(sum(len(one.payload) + 2 for one in streams) + sum(map(len, self._watched.values())))
        top.d.comb += [Cat(driven).eq(self._given),
                       self._seen.eq(Cat(*((one.valid, one.ready, one.payload) for one in streams),
                                       *self._watched.values()))]
        # Elaborated by the first run: a module's bench costs nothing where its tests are collected alone.
        self._top, self._simulator, self._error = top, None, None

    @property
    def cycles(self) -> dict[str, list[int]]:
        """See above."""
        return self.trace.cycles

    def run(self, schedule: Schedule, *responders: Responder, **ports) -> dict[str, list]:
        """What comes out of each output.

        Parameters
        ----------
        responders
            Answer what comes out.
        ports
            Values of inputs that are no streams; iterators over those of each cycle, of which the last one stays; or
            functions that give them after each cycle, of `cycles` so far.

        Raises
        ------
        AssertionError
            An item was never accepted, or an offer was withdrawn or changed.
        """
        self._schedule, self._ports, self._responders = schedule, ports, responders
        if self._simulator is None:
            self._simulator = simulator_of(self._top, self._bench)
        else:
            self._simulator.reset()
        self._simulator.run()
        if self._error is not None:
            raise self._error
        return {name: [unpack(self._outputs[name].shape, item) for item in items]
                for name, items in self.came.items()}

    async def _bench(self, ctx):
        """The run; what it raises is kept, since a simulator whose process has failed cannot be reset."""
        self._error = None
        try:
            await self._follow(ctx)
        except Exception as error:
            self._error = error

    async def _follow(self, ctx):
        """One process for all streams."""
        ports = [(getattr(self._component, port), value) for port, value in self._ports.items()]
        later = [(port, value) for port, value in ports if callable(value)]
        running = [(port, value) for port, value in ports if isinstance(value, Iterator)]
        for port, value in ports:
            if not callable(value) and not isinstance(value, Iterator):
                ctx.set(port, value)
        items, stalls, first = self._schedule.items, self._schedule.stalls, self._schedule.first
        sources = {name: _SourceState(items.get(name, ()), first.get(name, ()), one)
                   for name, one in self._inputs.items()}
        sinks = {name: _SinkState(stalls.get(name, ()), one, name) for name, one in self._outputs.items()}
        ends = [*sources.values(), *sinks.values()]
        answers = [(sinks[one.takes], self._outputs[one.takes].shape, sources[one.gives], one)
                   for one in self._responders]
        leading, generator = deque(sources[name] for name in first), Random(1)
        self.trace = Trace({name: [] for name in sources}, {name: set() for name in sinks},
                           {name: [] for name in (*sources, *sinks)})
        self.history = {name: [] for name in self._watched}
        still = cycle = 0
        for port, values in running:
            ctx.set(port, next(values))
        ctx.set(self._given, self._offers(leading, ends))
        async for *_, seen in ctx.tick().sample(self._seen):
            cycle, still = cycle + 1, still + 1
            assert cycle < self._watchdog, (
                f"the run does not end within {self._watchdog} cycles")
            for name, end in zip(self.cycles, ends, strict=True):
                valid, ready, payload = seen & 1, seen >> 1 & 1, seen >> 2 & (1 << end.width) - 1
                seen >>= 2 + end.width
                if valid and ready:
                    self.cycles[name].append(cycle)
                if name in sinks:
                    if not ready:
                        self.trace.stalled[name].add(cycle)
                elif valid and not end.offers:
                    self.trace.offered[name].append(cycle)
                if end.after(valid, ready, payload):
                    still = 0
            for name, values in self.history.items():
                width = len(self._watched[name])
                values.append(seen & (1 << width) - 1)
                seen >>= width
            for sink, shape, source, one in answers:
                for item in sink.came[sink.answered:]:
                    source.answer(one.delay(generator), one(unpack(shape, item)))
                sink.answered = len(sink.came)
            if still >= self._idle_limit:
                break
            for port, value in later:
                ctx.set(port, value(self.cycles))
            for port, values in running:
                for value in islice(values, 1):
                    ctx.set(port, value)
            ctx.set(self._given, self._offers(leading, ends))
        left = {name: source.left for name, source in sources.items() if source.left}
        assert not left, f"items were never accepted: {left}"
        self.came = {name: sink.came for name, sink in sinks.items()}

    @staticmethod
    def _offers(leading, ends):
        """The offers of a cycle; while there are leading items, only those of their input."""
        while leading and not leading[0].leads:
            leading.popleft()
        return _joined(end.gives(not leading or end is leading[0]) for end in ends)


def _joined(parts):
    """Numbers concatenated from the lowest bits on, given as pairs of number and bits."""
    bits = shift = 0
    for part, width in parts:
        bits |= part << shift
        shift += width
    return bits


class _Stream:
    """The signals of a component's stream."""

    def __init__(self, component, name):
        stream = stream_of(component, name)
        self.valid, self.ready, self.payload = stream.valid, stream.ready, Value.cast(stream.payload)
        self.shape = stream.signature.members["payload"].shape


class _SourceState:
    """An input's position in its schedule."""

    def __init__(self, given, first, one):
        self._shape, self.width, self.leads = one.shape, len(one.payload), len(first)
        self._given = deque([(0, pack(one.shape, value)) for value in first])
        self._given += [(idle, pack(one.shape, value)) for idle, value in given]
        self._idle = self._given[0][0] if self._given else 0
        # Whether an item was offered in the cycle before, and not accepted.
        self.offers = False

    @property
    def left(self):
        """Items that have not been taken."""
        return len(self._given)

    def answer(self, delay, values):
        """Offer values after some cycles."""
        for value in values:
            if not self._given:
                self._idle = delay
            self._given.append((delay, pack(self._shape, value)))
            delay = 0

    def gives(self, may):
        """``valid`` and payload, and their bits."""
        self._may = may
        offers = may and self._given and not self._idle
        # Without ``valid`` the payload has no meaning, and must have no effect.
        return 1 | self._given[0][1] << 1 if offers else (1 << self.width) // 3 << 1, self.width + 1

    def after(self, valid, ready, payload):
        """Whether something went on in a cycle."""
        self.offers = bool(valid and not ready)
        if not valid:
            waits = self._may and self._idle > 0
            self._idle -= waits
            return waits
        if ready:
            self._given.popleft()
            self.leads -= self.leads > 0
            self._idle = self._given[0][0] if self._given else 0
        return bool(ready)


class _SinkState:
    """An output's position in its schedule, and the items that have come."""

    def __init__(self, stalls, one, name):
        self._stalls, self._name, self._one, self.came = iter(stalls), name, one, []
        self._stall, self._offered, self.width = next(self._stalls, 0), None, len(one.payload)
        self.answered = 0

    def gives(self, may):
        """``ready``, and its bits."""
        return (0, 0) if isinstance(self._one.ready, Const) else (int(not self._stall), 1)

    def after(self, valid, ready, payload):
        """Whether something went on in a cycle."""
        if self._offered is not None:
            assert valid, f"{self._name}: an offer must stay until it is accepted"
            assert payload == self._offered, f"{self._name}: an offer must not change until it is accepted"
        waits = self._stall > 0
        self._stall -= waits
        self._offered = payload if valid and not ready else None
        if valid and ready:
            self.came.append(payload)
            self._stall = next(self._stalls, 0)
        return bool(waits or (valid and ready))
