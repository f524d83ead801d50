"""Longest waiting: who came first."""

from itertools import combinations

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

__all__ = ["LongestWaiting"]


class LongestWaiting(wiring.Component):
    """Of those that may go the one that has waited longest; of those that began in the same cycle the lowest.

    Parameters
    ----------
    count
        How many there are, at least 1.

    Members
    -------
    wants, asks, first, goes
        As those of `hw.lib.round_robin.RoundRobin`.

    Timing
    ------
    Latency: ``0`` cycles.

    Errors
    ------
    ValueError
        Count out of range.

    Source: Shen 1993, 5.3.8.
    """

    def __init__(self, *, count: int):
        if not isinstance(count, int) or count < 1:
            raise ValueError(f"Count must be at least 1, not {count!r}")
        self._count = count
        super().__init__({"wants": In(count), "asks": In(count), "first": Out(count), "goes": In(1)})
        self.latency = 0

    def elaborate(self, platform):
        m = Module()
        waits, before = Signal(self._count), [[] for _ in range(self._count)]
        m.d.sync += waits.eq(self.wants & ~Mux(self.goes, self.first, 0))
        # A bit per pair remembers who of the two came first.
        for a, b in combinations(range(self._count), 2):
            a_was_first, a_is_first = Signal(name=f"was_first_{a}_{b}"), Signal(name=f"is_first_{a}_{b}")
            m.d.comb += a_is_first.eq(Mux(waits[a] & waits[b], a_was_first, waits[a] | ~waits[b]))
            m.d.sync += a_was_first.eq(a_is_first)
            before[a].append(self.asks[b] & ~a_is_first)
            before[b].append(self.asks[a] & a_is_first)
        for k, others in enumerate(before):
            m.d.comb += self.first[k].eq(self.asks[k] & ~Cat(others).any())
        return m
