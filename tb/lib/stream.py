"""Drivers and monitors of a component's streams, for cocotb."""

import random
from collections.abc import Callable, Iterable, Iterator
from itertools import repeat

import cocotb
from cocotb.triggers import RisingEdge
from cocotb.utils import get_sim_time

from tb.lib.clocking import PERIOD

__all__ = ["Monitor", "Sink", "Source", "now"]


def now() -> int:
    """The number of the present cycle."""
    return round(get_sim_time("ns") / PERIOD)


class _Stream:
    """The signals of one stream: ``NAME__payload``, ``NAME__valid`` and, if it is not always ready, ``NAME__ready``.

    Of a stream that is always ready a signal inside the component may have the name that the port would have.
    """

    def __init__(self, dut, name: str, *, always_ready: bool = False):
        self._edge = RisingEdge(dut.clk)
        self.valid = getattr(dut, f"{name}__valid")
        self.ready = None if always_ready else getattr(dut, f"{name}__ready", None)
        # A stream without payload has no such signal.
        self.payload = getattr(dut, f"{name}__payload", None)
        self.name = name


class Source(_Stream):
    """Drives an input stream of a component; while ``valid`` is 0 the payload is random.

    Parameters
    ----------
    dut, name
        The component in the simulator, and the stream.
    stalls
        Whether to offer nothing, cycle by cycle; an offered item stays until it is accepted.

    Members
    -------
    offered, cycles
        The first cycle of each item's offer, and that of its transfer.
    """

    def __init__(self, dut, name: str, *, stalls: Iterator[bool] | None = None, **options):
        super().__init__(dut, name, **options)
        self.stalls = stalls or repeat(False)
        self._random = random.Random(name)
        self.offered, self.cycles = [], []
        self._offer_nothing()

    def _offer_nothing(self):
        self.valid.value = 0
        if self.payload is not None:
            self.payload.value = self._random.getrandbits(len(self.payload))

    async def send(self, items: Iterable[int]) -> None:
        """Send all items, and return when the last one has been accepted."""
        edge, valid, ready, payload, stalls = self._edge, self.valid, self.ready, self.payload, self.stalls
        for item in items:
            while next(stalls):
                self._offer_nothing()
                await edge
            valid.value = 1
            if payload is not None:
                payload.value = item
            await edge
            cycle = now()
            self.offered.append(cycle)
            while ready is not None and not int(ready.value):
                await edge
                cycle += 1
            self.cycles.append(cycle)
        self._offer_nothing()


class _Edges:
    """Steps all monitors of a test at each edge of a clock: a task for each of them takes twice as long."""

    _present: "_Edges | None" = None

    def __init__(self, clock):
        self._clock, self._monitors, self._new = clock, (), []
        self._task = cocotb.start_soon(self._run())

    @classmethod
    def of(cls, clock) -> "_Edges":
        """The present test's."""
        if cls._present is None or cls._present._task.done() or cls._present._clock is not clock:
            cls._present = cls(clock)
        return cls._present

    async def _run(self):
        edge = RisingEdge(self._clock)
        while True:
            await edge
            if self._new:
                # Other tasks run at an edge before this one or after it, and theirs are stepped from the next one on.
                present = get_sim_time()
                self._monitors = (*self._monitors, *(monitor for began, monitor in self._new if began < present))
                self._new = [(began, monitor) for began, monitor in self._new if began == present]
            for monitor in self._monitors:
                monitor.step()

    def add(self, monitor: "Monitor") -> None:
        """Step a monitor from the next edge on."""
        self._new.append((get_sim_time(), monitor))

    def remove(self, monitor: "Monitor") -> None:
        """Step a monitor no more."""
        self._monitors = tuple(one for one in self._monitors if one is not monitor)
        self._new = [(began, one) for began, one in self._new if one is not monitor]


class Monitor(_Stream):
    """Records what is transferred, in ``items``, and in which cycles, in ``cycles``.

    Parameters
    ----------
    seen
        Called with each item instead of keeping it.
    """

    def __init__(self, dut, name: str, *, seen: Callable[[int], None] | None = None, **options):
        super().__init__(dut, name, **options)
        self.items, self.cycles = [], []
        self._seen, self._edges = seen, _Edges.of(dut.clk)
        self._edges.add(self)

    def step(self) -> None:
        """At an edge of the clock."""
        if int(self.valid.value) and (self.ready is None or int(self.ready.value)):
            self._record()

    def _record(self):
        item = 0 if self.payload is None else int(self.payload.value)
        if self._seen is not None:
            self._seen(item)
        else:
            self.items.append(item)
            self.cycles.append(now())

    def stop(self) -> None:
        """Record nothing more."""
        self._edges.remove(self)


class Sink(Monitor):
    """Drives ``ready`` of an output stream of a component, and records its transfers.

    Parameters
    ----------
    stalls
        Whether ``ready`` is 0, cycle by cycle.

    Members
    -------
    stalled
        The cycles in which it was.
    """

    def __init__(self, dut, name: str, *, stalls: Iterator[bool] | None = None, **options):
        self.stalls, self.stalled = stalls or repeat(False), set()
        super().__init__(dut, name, **options)
        self._accepts = False
        if self.ready is not None:
            self.ready.value = 0
            # A pattern may depend on what is made after this sink.
            cocotb.start_soon(self._begin())

    async def _begin(self):
        self._accept()

    def _accept(self):
        """Set ``ready`` for the next edge."""
        accepts = not next(self.stalls)
        if accepts != self._accepts:
            self._accepts = accepts
            self.ready.value = int(accepts)

    def step(self) -> None:
        """See `Monitor.step`."""
        if self.ready is not None and not self._accepts:
            self.stalled.add(now())
        elif int(self.valid.value):
            self._record()
        if self.ready is not None:
            self._accept()

    def stop(self) -> None:
        """Accept and record nothing more."""
        super().stop()
        if self.ready is not None:
            self.ready.value = 0
