"""Arbiter: several streams to one, in a fair order."""

from itertools import combinations

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import enum, stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from hw.lib.round_robin import RoundRobin

__all__ = ["Arbiter", "ArbiterPolicy"]


class ArbiterPolicy(enum.Enum):
    """Who goes first.

    ``ROUND_ROBIN``: the next one after the one that went last. ``LONGEST_WAITING``: the one that came first; of those
    that came in the same cycle the one of the smallest number.
    """

    ROUND_ROBIN = 0
    LONGEST_WAITING = 1


class Arbiter(wiring.Component):
    """Merges streams, one item of any of them per cycle.

    An input waits while at most ``count`` - 1 items of others go, whatever the policy.

    Parameters
    ----------
    shape
        Of an item.
    count
        Inputs, at least 1.
    policy
        Who goes first.

    Members
    -------
    i
        An array of streams.
    o
        ``source``, the number of the input, and ``item``.

    Timing
    ------
    Latency: ``1`` cycle, if nobody else goes first. One item per cycle; stalls with ``o``; one item in flight.

    Errors
    ------
    ValueError
        Count out of range.
    TypeError
        The policy is none.

    Source: Shen 1993, 5.3.8, for ``LONGEST_WAITING``.
    """

    def __init__(self, shape, *, count: int, policy: ArbiterPolicy = ArbiterPolicy.ROUND_ROBIN):
        if not isinstance(count, int) or count < 1:
            raise ValueError(f"Count must be at least 1, not {count!r}")
        if not isinstance(policy, ArbiterPolicy):
            raise TypeError(f"Policy must be an ArbiterPolicy, not {policy!r}")
        self._count, self._policy = count, policy
        super().__init__({
            "i": In(stream.Signature(shape)).array(count),
            "o": Out(stream.Signature(StructLayout({"source": range(count), "item": shape})))})
        self.latency = 1

    def elaborate(self, platform):
        m = Module()
        asks, goes, moves = Signal(self._count), Signal(self._count), Signal()
        shown = Signal.like(self.o.payload, reset_less=True)
        first = self._add_round_robin if self._policy is ArbiterPolicy.ROUND_ROBIN else self._add_longest_waiting
        m.d.comb += [moves.eq(self.o.ready | ~self.o.valid), self.o.payload.eq(shown),
                     goes.eq(first(m, asks, goes) & moves.replicate(self._count))]
        with m.If(moves):
            m.d.sync += self.o.valid.eq(asks.any())
        for k, source in enumerate(self.i):
            m.d.comb += [asks[k].eq(source.valid), source.ready.eq(goes[k])]
            with m.If(goes[k]):
                m.d.sync += [shown.source.eq(k), shown.item.eq(source.payload)]
        return m

    def _add_round_robin(self, m, asks, goes):
        m.submodules.turns = turns = RoundRobin(count=self._count)
        m.d.comb += [turns.asks.eq(asks), turns.goes.eq(goes.any())]
        return turns.first

    def _add_longest_waiting(self, m, asks, goes):
        """The input in front of which nobody else is: a bit per pair remembers who of the two came first."""
        waits, behind = Signal(self._count), [[] for _ in range(self._count)]
        m.d.sync += waits.eq(asks & ~goes)
        for a, b in combinations(range(self._count), 2):
            a_was_first, a_is_first = Signal(name=f"was_first_{a}_{b}"), Signal(name=f"is_first_{a}_{b}")
            m.d.comb += a_is_first.eq(Mux(waits[a] & waits[b], a_was_first, waits[a] | ~waits[b]))
            m.d.sync += a_was_first.eq(a_is_first)
            behind[a].append(asks[b] & ~a_is_first)
            behind[b].append(asks[a] & a_is_first)
        first = Signal(self._count)
        for k, others in enumerate(behind):
            m.d.comb += first[k].eq(asks[k])
            for other in others:
                with m.If(other):
                    m.d.comb += first[k].eq(0)
        return first
