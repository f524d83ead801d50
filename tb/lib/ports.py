"""All streams and ports of a component in cocotb, with payloads as dicts."""

import random
from collections import deque
from collections.abc import Collection, Iterable, Iterator

import cocotb
from amaranth.hdl import Shape
from amaranth.lib.wiring import In, Out
from cocotb.task import Task
from cocotb.triggers import RisingEdge

from hw.lib.payload import pack, unpack
from tb.lib.clocking import reset
from tb.lib.responder import Responder
from tb.lib.runner import options
from tb.lib.signature import payload_shape, ports_of, stream_of, streams_of
from tb.lib.stages import Trace
from tb.lib.stall_patterns import STALLS, spaced
from tb.lib.stream import Monitor, Sink, Source

__all__ = ["Ports"]


class Ports:
    """Drives every input stream of a component and accepts from every output stream; ``ports[name]`` is a plain port.

    Parameters
    ----------
    dut
        The component in the simulator.
    component
        Has the signature.
    stalls
        By stream the name of a stall pattern, or a pattern; default: none.
    intervals
        By input stream the least cycles from an item to the next one.
    seed
        Of the patterns and of responders; default: the run's.
    others
        Streams that the testbench drives itself.

    Members
    -------
    sources, sinks
        By stream.
    payloads
        By stream the shape of its payload.
    """

    def __init__(self, dut, component, *, stalls: dict[str, str | Iterator[bool]] | None = None,
                 intervals: dict[str, int] | None = None, seed: int | None = None, others: Collection[str] = ()):
        self.dut, self.edge, self._signature = dut, RisingEdge(dut.clk), component.signature
        self._stalls, self._intervals = stalls or {}, intervals or {}
        self._seed = options()["seed"] if seed is None else seed
        self._shapes = ports_of(component.signature)
        self._streams = {flow: [name for name in names if name not in others]
                         for flow, names in streams_of(component.signature).items()}
        self.payloads = {name: payload_shape(component.signature, name)
                          for names in self._streams.values() for name in names}
        self._always_ready = {name for names in self._streams.values() for name in names
                              if stream_of(component, name).signature.always_ready}
        self._responders = ()
        self._connect()

    def _connect(self):
        self._tasks, self._monitors = [], {}
        self.sources, self.sinks = (
            {name: kind(self.dut, name, stalls=self._pattern(name), always_ready=name in self._always_ready)
             for name in self._streams[flow]} for kind, flow in ((Source, In), (Sink, Out)))
        for name in self._streams[Out]:
            if not Shape.cast(self.payloads[name]).width:
                # A payload without bits is an undriven port in Verilog.
                self.sinks[name].payload = None
        self.respond(*self._responders)

    def _pattern(self, name):
        pattern = self._stalls.get(name, "none")
        number = [*self._streams[In], *self._streams[Out]].index(name)
        pattern = STALLS[pattern](self._seed + number) if isinstance(pattern, str) else pattern
        return spaced(pattern, self._intervals[name]) if self._intervals.get(name, 1) > 1 else pattern

    def __setitem__(self, name: str, value) -> None:
        getattr(self.dut, name).value = pack(self._shapes[name], value)

    def __getitem__(self, name: str):
        return unpack(self._shapes[name], int(getattr(self.dut, name).value))

    async def send(self, name: str, items: Iterable) -> None:
        """Send items, and return when the last one has been accepted."""
        await self.sources[name].send([pack(self.payloads[name], item) for item in items])

    def begin(self, name: str, items: Iterable) -> Task:
        """Send items from now on; the task ends when the last one has been accepted."""
        return self.run(self.send(name, items))

    def run(self, coroutine) -> Task:
        """Run a coroutine until it ends, or until `stop`."""
        self._tasks.append(cocotb.start_soon(coroutine))
        return self._tasks[-1]

    def came(self, name: str, first: int = 0) -> list:
        """What has come out of a stream, from item ``first`` on."""
        return [unpack(self.payloads[name], item) for item in self.sinks[name].items[first:]]

    async def take(self, name: str, count: int) -> list:
        """Wait for the next ``count`` items of a stream."""
        first = len(self.sinks[name].items)
        await self.until(lambda: len(self.sinks[name].items) >= first + count)
        return self.came(name, first)

    async def until(self, condition) -> None:
        """Wait; the watchdog bounds it."""
        while not condition():
            await self.edge

    def taken(self, name: str) -> Monitor:
        """A monitor of an input stream, from the first call on."""
        if name not in self._monitors:
            self._monitors[name] = Monitor(self.dut, name, always_ready=name in self._always_ready)
        return self._monitors[name]

    @property
    def trace(self) -> Trace:
        """What has been offered, stalled and transferred."""
        return Trace({name: source.offered for name, source in self.sources.items()},
                     {name: sink.stalled for name, sink in self.sinks.items()},
                     {name: one.cycles for name, one in (self.sources | self.sinks).items()})

    def respond(self, *responders: Responder) -> None:
        """Answer from now on, also after a reset."""
        self._responders = responders
        for one in responders:
            self.run(self._answer(one))

    async def _answer(self, one):
        """A responder's answers, each after its delay, one after the other."""
        items, source, waiting = self.sinks[one.takes].items, self.sources[one.gives], deque()
        generator, takes, gives = random.Random(self._seed), self.payloads[one.takes], self.payloads[one.gives]
        seen = cycle = 0
        sending = None
        while True:
            for item in items[seen:]:
                answer = [pack(gives, value) for value in one(unpack(takes, item))]
                waiting.append((cycle + one.delay(generator), answer))
            seen = len(items)
            if waiting and waiting[0][0] <= cycle and (sending is None or sending.done()):
                sending = self.run(source.send(waiting.popleft()[1]))
            await self.edge
            cycle += 1

    def stop(self) -> None:
        """End all offers, acceptances and records."""
        for task in self._tasks:
            task.cancel()
        for monitor in (*self.sinks.values(), *self._monitors.values()):
            monitor.stop()
        for source in self.sources.values():
            source.valid.value = 0

    async def reset(self) -> None:
        """Stop whatever is in flight, reset the component, and begin anew with nothing recorded."""
        self.stop()
        await reset(self.dut)
        self._connect()
