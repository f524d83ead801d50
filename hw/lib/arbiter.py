"""Arbiter: several streams to one, in a fair order."""

from amaranth.hdl import Module, Signal
from amaranth.lib import enum, stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from hw.lib.longest_waiting import LongestWaiting
from hw.lib.round_robin import RoundRobin

__all__ = ["Arbiter", "ArbiterPolicy"]


class ArbiterPolicy(enum.Enum):
    """Who goes first.

    ``ROUND_ROBIN``: the next one after the one that went last. ``LONGEST_WAITING``: the one that came first; of those
    that came in the same cycle the one of the smallest number.
    """

    ROUND_ROBIN = 0
    LONGEST_WAITING = 1

    @property
    def rule(self) -> type[RoundRobin] | type[LongestWaiting]:
        """The component that knows whose turn it is."""
        return RoundRobin if self is ArbiterPolicy.ROUND_ROBIN else LongestWaiting


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
        asks, moves = Signal(self._count), Signal()
        shown = Signal.like(self.o.payload, reset_less=True)
        m.submodules.turns = turns = self._policy.rule(count=self._count)
        goes = turns.first & moves.replicate(self._count)
        m.d.comb += [moves.eq(self.o.ready | ~self.o.valid), self.o.payload.eq(shown),
                     turns.wants.eq(asks), turns.asks.eq(asks), turns.goes.eq(moves & asks.any())]
        with m.If(moves):
            m.d.sync += self.o.valid.eq(asks.any())
        for k, source in enumerate(self.i):
            m.d.comb += [asks[k].eq(source.valid), source.ready.eq(goes[k])]
            with m.If(goes[k]):
                m.d.sync += [shown.source.eq(k), shown.item.eq(source.payload)]
        return m
