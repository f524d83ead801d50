"""Work count: how much is under way, to say when nothing is."""

from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

__all__ = ["WorkCount"]


class WorkCount(wiring.Component):
    """What has come in less what has left, several of both in a cycle.

    Parameters
    ----------
    enters, leaves
        Places where items come in and where they leave, at least 1 each.
    most
        Items that there is room for.

    Members
    -------
    enters, leaves
        A bit for each place: an item passes it in this cycle. An item leaves in a later cycle than it has come.
    level
        Items under way, and those that left in the last cycle.
    empty
        There are none.

    Timing
    ------
    Latency: ``1`` cycle from an item that comes, ``2`` from one that leaves.

    Errors
    ------
    ValueError
        Numbers out of range.
    """

    latency = 1

    def __init__(self, *, enters: int, leaves: int, most: int):
        for name, value in ("Enters", enters), ("Leaves", leaves), ("Most", most):
            if not isinstance(value, int) or value < 1:
                raise ValueError(f"{name} must be at least 1, not {value!r}")
        super().__init__({"enters": In(enters), "leaves": In(leaves), "level": Out(range(most + 1)),
                          "empty": Out(1, init=1)})

    def elaborate(self, platform):
        m = Module()
        # It may be known late that all have left, never that one has come.
        after, left = Signal.like(self.level), Signal.like(self.leaves)
        m.d.comb += after.eq(self.level + sum(self.enters) - sum(left))
        m.d.sync += [left.eq(self.leaves), self.level.eq(after), self.empty.eq(after == 0)]
        return m
