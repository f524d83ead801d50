"""Group split: the grid rays of groups, one by one."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from hw.ctu.ctu_formats import GRID_GROUP
from hw.lib.queue import Queue
from hw.lib.skid_buffer import SkidBuffer

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
    Latency: ``2`` cycles. One ray per cycle; stalls with ``o``, a cycle later.
    """

    def __init__(self, shape: StructLayout):
        self._group = StructLayout({"first": shape, "count": range(GRID_GROUP + 1)})
        super().__init__({"i": In(stream.Signature(self._group)), "o": Out(stream.Signature(shape)), "leaves": Out(1)})
        self._queue, self._skid = Queue(self._group, depth=GROUPS), SkidBuffer(shape)
        self.latency = self._queue.latency + self._skid.latency

    def elaborate(self, platform):
        m = Module()
        m.submodules.groups, m.submodules.skid = groups, skid = self._queue, self._skid
        wiring.connect(m, wiring.flipped(self.i), groups.i)
        wiring.connect(m, skid.o, wiring.flipped(self.o))
        group, shown, last = groups.o, skid.i, Signal.like(self.o.payload, reset_less=True)
        # Rays of the last group that are left, and whether there are any.
        more, follows = Signal(range(GRID_GROUP)), Signal()
        m.d.comb += [
            shown.valid.eq(group.valid | follows), shown.payload.eq(group.payload.first),
            group.ready.eq(shown.ready & ~follows), self.leaves.eq(group.valid & group.ready)]
        with m.If(follows):
            m.d.comb += [shown.payload.eq(last), shown.payload.ray.eq(last.ray + 1),
                         shown.payload.column.eq(last.column + 1)]
        with m.If(shown.ready):
            m.d.sync += last.eq(shown.payload)
            with m.If(follows):
                m.d.sync += [more.eq(more - 1), follows.eq(more != 1)]
            with m.Else():
                m.d.sync += [more.eq(group.payload["count"] - 1), follows.eq(
                    group.valid & (group.payload["count"] != 1))]
        return m
