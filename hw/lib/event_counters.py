"""Event counters: how often each of several events has occurred."""

from collections.abc import Mapping

from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from hw.lib.validate import check_integer

__all__ = ["EventCounters"]


class EventCounters(wiring.Component):
    """Adds the events of each cycle to counters that wrap.

    Parameters
    ----------
    events
        Shape of each event's number per cycle, by name: 1 for one that occurs once per cycle at most.
    bits
        Of a counter, at least 1.

    Members
    -------
    events : In, struct of ``events``
        Their numbers in this cycle.
    clear : In(1)
        The counters begin at 0.
    counters : Out, struct of ``events``, ``bits`` each
        The sums since then.

    Timing
    ------
    Latency: ``2`` cycles from an event to its counter: events come from all over a unit, and pass a register first.

    Raises
    ------
    TypeError
        The bits are no integer.
    ValueError
        The bits are out of range.
    """

    def __init__(self, events: Mapping, *, bits: int):
        check_integer("Bits", bits, minimum=1)
        super().__init__({"events": In(StructLayout(dict(events))), "clear": In(1),
                          "counters": Out(StructLayout(dict.fromkeys(events, bits)))})
        self.latency = 2

    def elaborate(self, platform):
        m = Module()
        now = Signal.like(self.events)
        m.d.sync += now.eq(self.events)
        for name, _ in self.events.shape():
            m.d.sync += self.counters[name].eq(self.counters[name] + now[name])
            with m.If(self.clear):
                m.d.sync += self.counters[name].eq(0)
        return m
