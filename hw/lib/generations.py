"""Generations: tags that make a memory empty at once, and the sweep that makes it empty when they run out."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

__all__ = ["Generations"]


class Generations(wiring.Component):
    """What carries another tag than the current generation's counts as empty. Tag 0 is nobody's.

    After reset, and when all tags have been used, every row is given tag 0 once before the next generation begins.

    Parameters
    ----------
    bits
        Of a tag.
    depth
        Rows.

    Members
    -------
    i_start
        Begins a generation; taken when the memory is empty. No payload.
    generation
        The current tag.
    sweeps, row
        This row is to be given tag 0 in this cycle.

    Timing
    ------
    Latency: ``1`` cycle, after a sweep of ``depth`` cycles every 2^``bits`` - 1 generations.
    """

    def __init__(self, *, bits: int, depth: int):
        self._last, self._depth = (1 << bits) - 1, depth
        super().__init__({"i_start": In(stream.Signature(0)), "generation": Out(bits, init=self._last),
                          "sweeps": Out(1), "row": Out(range(depth))})
        self.latency = 1

    def elaborate(self, platform):
        m = Module()
        swept = Signal()
        runs_out = self.generation == self._last
        m.d.comb += [self.sweeps.eq(self.i_start.valid & runs_out & ~swept),
                     self.i_start.ready.eq(~runs_out | swept)]
        with m.If(self.sweeps):
            m.d.sync += self.row.eq(self.row + 1)
            with m.If(self.row == self._depth - 1):
                m.d.sync += [self.row.eq(0), swept.eq(1)]
        with m.If(self.i_start.valid & self.i_start.ready):
            m.d.sync += [swept.eq(0), self.generation.eq(self.generation + 1)]
            with m.If(runs_out):
                m.d.sync += self.generation.eq(1)
        return m
