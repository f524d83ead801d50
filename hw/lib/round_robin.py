"""Round robin: grants requests in turn."""

from amaranth.hdl import Cat, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hw.lib.validate import check_integer

__all__ = ["RoundRobin"]


class RoundRobin(wiring.Component):
    """Grants the next eligible request after the last accepted one; after reset the lowest.

    Parameters
    ----------
    count
        Number of requests, at least 1.

    Members
    -------
    request : In(count)
        All pending requests, eligible or not. This rule does not need them.
    eligible : In(count)
        The requests that can be granted now.
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
    """

    def __init__(self, *, count: int):
        check_integer("Count", count, minimum=1)
        self._count = count
        super().__init__({"request": In(count), "eligible": In(count), "grant": Out(count), "accept": In(1)})
        self.latency = 0

    def elaborate(self, platform):
        m = Module()
        # Requests above the last accepted one.
        above = Signal(self._count)
        for k in range(self._count):
            # Each grant depends on all other requests at once: a chain from one to the next would be a longer path.
            others = [self.eligible[j] & (~above[k] | above[j] if j < k else ~above[k] & above[j])
                      for j in range(self._count) if j != k]
            m.d.comb += self.grant[k].eq(self.eligible[k] & ~Cat(others).any())
            with m.If(self.accept):
                m.d.sync += above[k].eq(self.grant[:k].any())
        return m
