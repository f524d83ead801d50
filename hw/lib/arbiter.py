"""Arbiter: merges several streams into one, fairly."""

from amaranth.hdl import Module, Signal
from amaranth.lib import enum, stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from hw.lib.longest_waiting import LongestWaiting
from hw.lib.round_robin import RoundRobin
from hw.lib.validate import check_instance, check_integer

__all__ = ["Arbiter", "ArbiterPolicy"]


class ArbiterPolicy(enum.Enum):
    """Which request is granted.

    ``ROUND_ROBIN``: the next one after the last one granted. ``LONGEST_WAITING``: the oldest one; of requests of the
    same cycle the one with the smallest number.
    """

    ROUND_ROBIN = 0
    LONGEST_WAITING = 1

    @property
    def rule(self) -> type[RoundRobin] | type[LongestWaiting]:
        """The component that makes the grants."""
        return RoundRobin if self is ArbiterPolicy.ROUND_ROBIN else LongestWaiting


class Arbiter(wiring.Component):
    """Merges streams, one item of any of them per cycle.

    An input waits for at most ``count`` - 1 items of others, whatever the policy.

    Parameters
    ----------
    shape
        Of an item.
    count
        Number of inputs, at least 1.
    policy
        Which request is granted.

    Members
    -------
    i : In, ``count`` streams of the item's shape
        The inputs.
    o : Out, stream of ``source``, ``item``
        The number of the input, and its item.

    Timing
    ------
    Latency: ``1`` cycle without contention. One item per cycle; stalls while the item at the end waits.

    Raises
    ------
    TypeError
        The count is no integer, or the policy no `ArbiterPolicy`.
    ValueError
        The count is out of range.

    Source: Shen 1993, 5.3.8, for ``LONGEST_WAITING``.
    """

    def __init__(self, shape, *, count: int, policy: ArbiterPolicy = ArbiterPolicy.ROUND_ROBIN):
        check_integer("Count", count, minimum=1)
        check_instance("Policy", policy, ArbiterPolicy)
        self._count, self._policy = count, policy
        super().__init__({
            "i": In(stream.Signature(shape)).array(count),
            "o": Out(stream.Signature(StructLayout({"source": range(count), "item": shape})))})
        self.latency = 1

    def elaborate(self, platform):
        m = Module()
        requests, advance = Signal(self._count), Signal()
        output = Signal.like(self.o.payload, reset_less=True)
        m.submodules.rule = rule = self._policy.rule(count=self._count)
        taken = rule.grant & advance.replicate(self._count)
        m.d.comb += [advance.eq(self.o.ready | ~self.o.valid), self.o.payload.eq(output),
                     rule.request.eq(requests), rule.eligible.eq(requests), rule.accept.eq(advance & requests.any())]
        with m.If(advance):
            m.d.sync += self.o.valid.eq(requests.any())
        for k, source in enumerate(self.i):
            m.d.comb += [requests[k].eq(source.valid), source.ready.eq(taken[k])]
            with m.If(taken[k]):
                m.d.sync += [output.source.eq(k), output.item.eq(source.payload)]
        return m
