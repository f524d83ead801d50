"""Group split: the grid rays of groups, one by one."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from hw.ctu.ctu_formats import GRID_GROUP
from hw.lib.queue import Queue

__all__ = ["GroupSplit"]

# Groups that wait.
GROUPS = 8


class GroupSplit(wiring.Component):
    """Of a group of n the rays ``ray``, ``ray + 1``, ... in ``column``, ``column + 1``, ...

    Parameters
    ----------
    shape
        Of a grid ray, with members ``ray`` and ``column``.

    Members
    -------
    i : In, stream of ``first``, ``count``
        A group: its first grid ray, and how many there are, at least one.
    o : Out, stream of the grid ray's shape
        Its grid rays.
    leaves : Out(1)
        A group leaves its buffer entry.

    Timing
    ------
    Latency: ``2`` cycles. One ray per cycle; stalls with ``o``.
    """

    def __init__(self, shape: StructLayout):
        self._group = StructLayout({"first": shape, "count": range(GRID_GROUP + 1)})
        super().__init__({"i": In(stream.Signature(self._group)), "o": Out(stream.Signature(shape)), "leaves": Out(1)})
        self.latency = 2

    def elaborate(self, platform):
        m = Module()
        m.submodules.groups = groups = Queue(self._group, depth=GROUPS)
        wiring.connect(m, wiring.flipped(self.i), groups.i)
        group, shown, more = groups.o, self.o, Signal(range(GRID_GROUP))
        leaves = shown.ready | ~shown.valid
        m.d.comb += [group.ready.eq(leaves & (more == 0)), self.leaves.eq(group.valid & group.ready)]
        with m.If(leaves):
            with m.If(more != 0):
                m.d.sync += [more.eq(more - 1), shown.payload.ray.eq(shown.payload.ray + 1),
                             shown.payload.column.eq(shown.payload.column + 1)]
            with m.Else():
                m.d.sync += [shown.valid.eq(group.valid), shown.payload.eq(group.payload.first)]
                with m.If(group.valid):
                    m.d.sync += more.eq(group.payload["count"] - 1)
        return m
