"""Longest waiting: grants the oldest request."""

from itertools import combinations

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hw.lib.validate import check_integer

__all__ = ["LongestWaiting"]


class LongestWaiting(wiring.Component):
    """Grants the eligible request that has been pending longest; of requests of the same cycle the lowest.

    Parameters
    ----------
    count
        Number of requests, at least 1.

    Members
    -------
    request, eligible : In(count)
        As of `hw.lib.round_robin.RoundRobin`; a request ages while it is pending, eligible or not.
    grant : Out(count)
        One eligible request, or none if none is eligible.
    accept : In(1)
        The grant is used in this cycle. Only while a request is eligible.

    Timing
    ------
    Latency: ``0`` cycles.

    Raises
    ------
    TypeError
        The count is no integer.
    ValueError
        The count is out of range.

    Source: Shen 1993, 5.3.8.
    """

    def __init__(self, *, count: int):
        check_integer("Count", count, minimum=1)
        self._count = count
        super().__init__({"request": In(count), "eligible": In(count), "grant": Out(count), "accept": In(1)})
        self.latency = 0

    def elaborate(self, platform):
        m = Module()
        pending, older = Signal(self._count), [[] for _ in range(self._count)]
        m.d.sync += pending.eq(self.request & ~Mux(self.accept, self.grant, 0))
        # A bit per pair remembers which of the two is older.
        for a, b in combinations(range(self._count), 2):
            a_was_older, a_is_older = Signal(name=f"was_older_{a}_{b}"), Signal(name=f"is_older_{a}_{b}")
            m.d.comb += a_is_older.eq(Mux(pending[a] & pending[b], a_was_older, pending[a] | ~pending[b]))
            m.d.sync += a_was_older.eq(a_is_older)
            older[a].append(self.eligible[b] & ~a_is_older)
            older[b].append(self.eligible[a] & a_is_older)
        for k, others in enumerate(older):
            m.d.comb += self.grant[k].eq(self.eligible[k] & ~Cat(others).any())
        return m
