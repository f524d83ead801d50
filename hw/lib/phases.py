"""Phases: an item stays for several cycles, so that few operators can work for all of it."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

__all__ = ["Phases"]


class Phases(wiring.Component):
    """Shows each item ``count`` times, every ``interval`` cycles, with the number of the time.

    Parameters
    ----------
    shape
        Of an item.
    count
        Phases, at least 2.
    interval
        Cycles from a phase to the next one, at least 1.

    Members
    -------
    i
        Items, at least ``count`` intervals apart. Always ready.
    o
        ``phase`` and ``item``, which stays until the next item comes. Always ready.

    Timing
    ------
    Latency: ``1`` cycle to phase 0; the phases follow each other without gaps. One item per ``count`` intervals.
    """

    def __init__(self, shape, *, count: int = 4, interval: int = 1):
        if count < 2:
            raise ValueError(f"Count must be at least 2, not {count!r}")
        if interval < 1:
            raise ValueError(f"Interval must be at least 1, not {interval!r}")
        self._count, self._interval = count, interval
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
        return m
