"""Generations: tags that clear a memory in one cycle, and the sweep for when they run out."""

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hw.lib.validate import check_integer

__all__ = ["Generations"]


class Generations(wiring.Component):
    """A row whose tag is not the current generation's counts as empty. Tag 0 belongs to no generation.

    After reset, and when all tags have been used, a sweep writes tag 0 to every row before the next generation begins.

    Parameters
    ----------
    bits
        Of a tag, at least 1.
    depth
        Number of rows, at least 1.

    Members
    -------
    i_start : In, stream without payload
        Begins a generation; accepted when the memory is empty.
    generation : Out(bits)
        The current tag.
    sweeps : Out(1)
        The sweep writes tag 0 to ``row`` in this cycle.
    row : Out(range(depth))
        The row that the sweep has reached.

    Timing
    ------
    Latency: ``1`` cycle, after a sweep of ``depth`` cycles every 2^``bits`` - 1 generations.

    Raises
    ------
    TypeError
        Bits or depth are no integers.
    ValueError
        Bits or depth are out of range.
    """

    def __init__(self, *, bits: int, depth: int):
        check_integer("Bits", bits, minimum=1)
        check_integer("Depth", depth, minimum=1)
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
