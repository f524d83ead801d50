"""Work count: the number of items in flight, to know when there are none."""

from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hw.lib.checks import claim, count_entries
from hw.lib.validate import check_integer

__all__ = ["WorkCount"]


class WorkCount(wiring.Component):
    """Counts the items in flight: those that have entered less those that have left, several of both in a cycle.

    Parameters
    ----------
    enters, leaves
        Number of ports where items enter and where they leave, at least 1 each.
    most
        Items in flight at most.

    Members
    -------
    enters : In(enters)
        A bit for each port: an item enters in this cycle.
    leaves : In(leaves)
        Likewise, an item leaves, in a later cycle than it has entered.
    level : Out(range(most + 1))
        Items in flight, and those that left in the last cycle.
    empty : Out(1)
        No item is in flight.

    Timing
    ------
    Latency: ``1`` cycle from an item that enters, ``2`` from one that leaves.

    Raises
    ------
    TypeError
        An argument is no integer.
    ValueError
        An argument is out of range.
    """

    latency = 1

    def __init__(self, *, enters: int, leaves: int, most: int):
        for name, value in ("Enters", enters), ("Leaves", leaves), ("Most", most):
            check_integer(name, value, minimum=1)
        self._most = most
        super().__init__({"enters": In(enters), "leaves": In(leaves), "level": Out(range(most + 1)),
                          "empty": Out(1, init=1)})

    def elaborate(self, platform):
        m = Module()
        # That all have left may be known late, that one has entered never.
        after, left = Signal.like(self.level), Signal.like(self.leaves)
        m.d.comb += after.eq(self.level - sum(left))
        count_entries(self.level)
        claim(m, sum(left) <= self.level, "what leaves has entered")
        claim(m, after + sum(self.enters) <= self._most, f"at most {self._most} are in flight")
        # Nothing is counted or compared behind what enters.
        m.d.sync += [left.eq(self.leaves), self.level.eq(after + sum(self.enters)),
                     self.empty.eq((after == 0) & ~self.enters.any())]
        return m
