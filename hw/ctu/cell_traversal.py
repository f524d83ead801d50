"""Cell traversal: from grid rays to the cells that they meet in their shells."""

from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.ctu.cell_number import CellNumber
from hw.ctu.cell_steps import CellSteps
from hw.ctu.traversal_start import TraversalStart
from hw.formats import Formats

__all__ = ["CellTraversal"]


class CellTraversal(wiring.Component):
    """`TraversalStart`, `CellSteps` and `CellNumber` in a row.

    Parameters
    ----------
    config
        The configuration.
    tag
        Shape of what goes along.

    Members
    -------
    i
        ``tag``, ``direction`` (G), ``begin`` and ``length`` of its shell.
    o
        ``tag``, number of a ``cell``, ``is_cell``: there is one, ``last`` of the ray. Every ray has a last item, which
        need not be a cell.
    origin, shape
        The frustum's origin in cells and the grid's cells along each axis; the same while rays are under way.

    Timing
    ------
    Latency: ``3 * product_registers + 26`` cycles to a ray's first cell. One cell per cycle where at least 5 rays wait
    or are under way; stands while a cell waits.

    Golden counterpart: `golden.ctu.cell_traversal.Traversal`. Source: Shen 1993, section 5.3.4.5.
    """

    def __init__(self, *, config: Config, tag):
        formats = Formats(config)
        step = StructLayout({"tag": tag, "is_cell": 1, "last": 1})
        self._start, self._steps = TraversalStart(config=config, tag=tag), CellSteps(config=config, tag=tag)
        self._number = CellNumber(config=config, tag=step)
        super().__init__({
            "i": In(self._start.i.signature.flip()),
            "o": Out(stream.Signature(StructLayout({"tag": tag, "cell": formats.cell, "is_cell": 1, "last": 1}))),
            "origin": In(ArrayLayout(formats.place, 3)), "shape": In(ArrayLayout(formats.grid_count, 3))})
        self.latency = self._start.latency + self._steps.latency + self._number.latency

    def elaborate(self, platform):
        m = Module()
        m.submodules.start, m.submodules.steps, m.submodules.number = start, steps, number = (
            self._start, self._steps, self._number)
        wiring.connect(m, wiring.flipped(self.i), start.i)
        wiring.connect(m, start.o, steps.i)
        m.d.comb += start.origin.eq(self.origin)
        m.d.comb += [block.shape.eq(self.shape) for block in (start, steps, number)]
        met, made = steps.o, number.o
        m.d.comb += [
            number.i.valid.eq(met.valid), met.ready.eq(number.i.ready), number.i.payload.index.eq(met.payload.index),
            self.o.valid.eq(made.valid), made.ready.eq(self.o.ready), self.o.payload.cell.eq(made.payload.cell),
            self.o.payload.tag.eq(made.payload.tag.tag)]
        for name in ("is_cell", "last"):
            m.d.comb += [number.i.payload.tag[name].eq(met.payload[name]),
                         self.o.payload[name].eq(made.payload.tag[name])]
        m.d.comb += number.i.payload.tag.tag.eq(met.payload.tag)
        return m
