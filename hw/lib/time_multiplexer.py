"""Time multiplexer: repeats an item with a phase number, so that few operators work on all of its parts."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.wiring import In, Out

from hw.lib.validate import check_instance, check_integer

__all__ = ["TimeMultiplexer"]


class TimeMultiplexer(wiring.Component):
    """Gives each item ``count`` times, every ``interval`` cycles, with phase 0, 1, ... ``count`` - 1.

    Parameters
    ----------
    shape
        Of an item.
    count
        Number of phases, at least 2.
    interval
        Cycles per phase, at least 1.
    turned
        The name of a field of an item, an array of ``count`` elements, or None. It turns by an element with each phase:
        its element 0 is the phase's own one, so that no multiplexer chooses it.

    Members
    -------
    i : In, stream of the item's shape, always ready
        Items, at least ``count`` intervals apart.
    o : Out, stream of ``phase``, ``item``, always ready
        The item of a phase; it stays until the next item, but for the field that is turned.

    Timing
    ------
    Latency: ``1`` cycle to phase 0; phases follow each other without gaps. One item per ``count`` intervals.

    Raises
    ------
    TypeError
        Count or interval are no integers, or the name is no string.
    ValueError
        Count or interval are out of range, or no field that is such an array has the name.
    """

    def __init__(self, shape, *, count: int, interval: int = 1, turned: str | None = None):
        check_integer("Count", count, minimum=2)
        check_integer("Interval", interval, minimum=1)
        if turned is not None:
            check_instance("Turned", turned, str)
            field = shape.members.get(turned) if isinstance(shape, StructLayout) else None
            if not isinstance(field, ArrayLayout) or field.length != count:
                raise ValueError(f"Turned must be the name of an array of {count} elements, not {turned!r}")
        self._count, self._interval, self._turned = count, interval, turned
        super().__init__({
            "i": In(stream.Signature(shape, always_ready=True)),
            "o": Out(stream.Signature(StructLayout({"phase": range(count), "item": shape}), always_ready=True))})
        self.latency = 1

    def elaborate(self, platform):
        m = Module()
        phase, runs, since = Signal(range(self._count)), Signal(), Signal(range(self._interval))
        item = Signal.like(self.o.payload.item, reset_less=True)
        m.d.comb += [self.o.payload.phase.eq(phase), self.o.payload.item.eq(item), self.o.valid.eq(runs & (since == 0))]
        with m.If(self.i.valid):
            m.d.sync += [item.eq(self.i.payload), phase.eq(0), since.eq(0), runs.eq(1)]
        with m.Elif(since != self._interval - 1):
            m.d.sync += since.eq(since + 1)
        with m.Else():
            m.d.sync += since.eq(0)
            with m.If(phase == self._count - 1):
                m.d.sync += runs.eq(0)
            with m.Else():
                m.d.sync += phase.eq(phase + 1)
            if self._turned is not None:
                # Also without an item: with an interval of 1 the registers then have no enable.
                parts = item[self._turned]
                m.d.sync += [parts[k].eq(parts[(k + 1) % self._count]) for k in range(self._count)]
        return m
