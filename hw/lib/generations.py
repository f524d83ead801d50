"""Generations: tags that clear a memory in one cycle, and the sweep for when they run out."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from hw.lib.validate import check_integer

__all__ = ["Generations"]


class Generations(wiring.Component):
    """A row whose tag is not the current generation's counts as empty. Tag 0 belongs to no generation.

    After reset, and when all tags have been used, a sweep writes tag 0 to every row. A generation begins when the sweep
    has passed the rows that it uses; the sweep goes on meanwhile, in the cycles in which the memory is not ``busy``.

    Parameters
    ----------
    bits
        Of a tag, at least 1.
    depth
        Number of rows, at least 1.

    Members
    -------
    i_start : In, stream without payload
        Begins a generation; accepted when the rows that it uses are empty.
    rows : In(range(depth + 1))
        The next generation uses the rows below it. Initially ``depth``. Stable while ``i_start`` is valid.
    idle : In(1)
        No row of the present generation is used any more: a sweep may begin before ``i_start``.
    busy : In(1)
        The memory is accessed in this cycle: no row is swept.
    generation : Out(bits)
        The current tag.
    sweeps : Out(1)
        The sweep writes tag 0 to ``row`` in this cycle.
    row : Out(range(depth))
        The row that the sweep has reached.

    Timing
    ------
    Latency: ``1`` cycle, every 2^``bits`` - 1 generations after a sweep of ``rows`` cycles that has not run ahead.

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
        super().__init__({
            "i_start": In(stream.Signature(0)), "rows": In(range(depth + 1), init=depth), "idle": In(1), "busy": In(1),
            "generation": Out(bits, init=self._last), "sweeps": Out(1), "row": Out(range(depth))})
        self.latency = 1

    def elaborate(self, platform):
        m = Module()
        # Rows that have no tag of a generation before generation 1.
        swept = Signal(range(self._depth + 1))
        runs_out, following = self.generation == self._last, Signal.like(self.generation)
        m.d.comb += [
            self.sweeps.eq((swept != self._depth) & ~self.busy & (~runs_out | self.idle | self.i_start.valid)),
            self.row.eq(swept), self.i_start.ready.eq(swept >= self.rows),
            following.eq(Mux(runs_out, 1, self.generation + 1))]
        with m.If(self.sweeps):
            m.d.sync += swept.eq(swept + 1)
        with m.If(self.i_start.valid & self.i_start.ready):
            m.d.sync += self.generation.eq(following)
            # The last generation uses rows that are swept already.
            with m.If(following == self._last):
                m.d.sync += swept.eq(0)
        return m
