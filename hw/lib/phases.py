"""Phases: an item stays for several cycles, so that few operators can work for all of it."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

__all__ = ["Phases"]


class Phases(wiring.Component):
    """Shows each item ``count`` times, with the number of the time.

    Parameters
    ----------
    shape
        Of an item.
    count
        Phases, at least 2.

    Members
    -------
    i
        Items, at least ``count`` cycles apart. Always ready.
    o
        ``phase`` and ``item``. Always ready.

    Timing
    ------
    Latency: ``1`` cycle to phase 0; the phases follow each other without gaps. One item per ``count`` cycles.
    """

    def __init__(self, shape, *, count: int = 4):
        if count < 2:
            raise ValueError(f"Count must be at least 2, not {count!r}")
        self._count = count
        super().__init__({
            "i": In(stream.Signature(shape, always_ready=True)),
            "o": Out(stream.Signature(StructLayout({"phase": range(count), "item": shape}), always_ready=True))})
        self.latency = 1

    def elaborate(self, platform):
        m = Module()
        phase = Signal(range(self._count))
        item = Signal.like(self.o.payload.item, reset_less=True)
        m.d.comb += [self.o.payload.phase.eq(phase), self.o.payload.item.eq(item)]
        with m.If(self.i.valid):
            m.d.sync += [item.eq(self.i.payload), phase.eq(0), self.o.valid.eq(1)]
        with m.Elif(phase == self._count - 1):
            m.d.sync += self.o.valid.eq(0)
        with m.If(~self.i.valid & self.o.valid):
            m.d.sync += phase.eq(phase + 1)
        return m
