"""Round robin: whose turn it is."""

from amaranth.hdl import Cat, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

__all__ = ["RoundRobin"]


class RoundRobin(wiring.Component):
    """Of those that ask the next one after the one that went last; after reset the lowest.

    Parameters
    ----------
    count
        How many there are, at least 1.

    Members
    -------
    wants
        Those that wait, whether they may go or not. They keep their turn; this rule need not look at them.
    asks
        Those of them that may go.
    first
        The one whose turn it is, or none if none asks.
    goes
        It takes its turn in this cycle; only when one asks.

    Timing
    ------
    Latency: ``0`` cycles.

    Errors
    ------
    ValueError
        Count out of range.
    """

    def __init__(self, *, count: int):
        if not isinstance(count, int) or count < 1:
            raise ValueError(f"Count must be at least 1, not {count!r}")
        self._count = count
        super().__init__({"wants": In(count), "asks": In(count), "first": Out(count), "goes": In(1)})
        self.latency = 0

    def elaborate(self, platform):
        m = Module()
        # Those above the one that went last.
        above = Signal(self._count)
        for k in range(self._count):
            # Each looks at all others at once: a chain from one to the next would take longer.
            waits = [self.asks[j] & (~above[k] | above[j] if j < k else ~above[k] & above[j])
                     for j in range(self._count) if j != k]
            m.d.comb += self.first[k].eq(self.asks[k] & ~Cat(waits).any())
            with m.If(self.goes):
                m.d.sync += above[k].eq(self.first[:k].any())
        return m
