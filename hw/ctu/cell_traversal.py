"""Cell traversal: from grid rays to the cells that they meet in their shells."""

from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.ctu.cell_number import CellNumber
from hw.ctu.cell_steps import CellSteps
from hw.ctu.ctu_formats import CtuFormats
from hw.ctu.traversal_start import TraversalStart
from hw.lib.arbiter import Arbiter
from hw.lib.round_robin import RoundRobin
from hw.lib.validate import check_integer

__all__ = ["CellTraversal"]


class CellTraversal(wiring.Component):
    """`TraversalStart`, then `CellSteps` and `CellNumber`, or several of both.

    A ray enters a pipeline with a free position, one ray after the other.

    Parameters
    ----------
    config
        The configuration.
    tag
        Shape of the sideband.
    pipelines
        How many of both, at least 1.

    Members
    -------
    i : In, stream of ``tag``, ``direction``, ``begin``, ``length``
        A ray: its direction in G, and its shell.
    o : Out, stream of ``tag``, ``cell``, ``is_cell``, ``last``
        Numbers of cells. Every ray has a last item, which need not be a cell.
    origin, shape : In, arrays of 3
        The frustum's origin in cells and the grid's cells along each axis; constant while rays are in flight.
    steps : Out(pipelines)
        The pipelines in which a ray steps in this cycle.

    Timing
    ------
    Latency: ``3 * product_registers + 29`` cycles to a ray's first cell, with several pipelines one more. One
    ray per cycle, and one cell per cycle and pipeline where at least 5 rays wait or are in flight in each; stalls while
    a cell waits. One item per cycle comes out.

    Raises
    ------
    TypeError, ValueError
        Pipelines of the wrong type or out of range.

    Golden counterpart: `golden.engine.ctu.cell_traversal.Traversal`. Source: Shen 1993, section 5.3.4.5.
    """

    def __init__(self, *, config: Config, tag, pipelines: int = 1):
        check_integer("Pipelines", pipelines, minimum=1)
        formats = CtuFormats(config)
        step = StructLayout({"tag": tag, "is_cell": 1, "last": 1})
        self._start = TraversalStart(config=config, tag=tag)
        self._steps = [CellSteps(config=config, tag=tag) for _ in range(pipelines)]
        self._numbers = [CellNumber(config=config, tag=step) for _ in range(pipelines)]
        super().__init__({
            "i": In(self._start.i.signature.flip()),
            "o": Out(stream.Signature(StructLayout({"tag": tag, "cell": formats.cell, "is_cell": 1, "last": 1}))),
            "origin": In(ArrayLayout(formats.grid_coordinate, 3)), "shape": In(ArrayLayout(formats.grid_count, 3)),
            "steps": Out(pipelines)})
        self._merge = Arbiter(self._numbers[0].o.payload.shape(), count=pipelines) if pipelines > 1 else None
        self.latency = (pipelines > 1) + sum(block.latency for block in (
            self._start, self._steps[0], self._numbers[0]))

    def elaborate(self, platform):
        m = Module()
        m.submodules.start, count = self._start, len(self._steps)
        wiring.connect(m, wiring.flipped(self.i), self._start.i)
        m.d.comb += [self._start.origin.eq(self.origin), self._start.shape.eq(self.shape)]
        m.submodules.arbiter = arbiter = RoundRobin(count=count)
        free, begins = arbiter.eligible, self._start.o
        m.d.comb += [arbiter.request.eq(free), begins.ready.eq(free.any()),
                     arbiter.accept.eq(begins.valid & free.any())]
        for k, (steps, number) in enumerate(zip(self._steps, self._numbers, strict=True)):
            m.submodules[f"steps_{k}"], m.submodules[f"number_{k}"] = steps, number
            met, given = steps.o, number.i
            m.d.comb += [
                steps.shape.eq(self.shape), number.shape.eq(self.shape), free[k].eq(steps.i.ready),
                steps.i.valid.eq(begins.valid & arbiter.grant[k]), steps.i.payload.eq(begins.payload),
                given.valid.eq(met.valid), met.ready.eq(given.ready), given.payload.index.eq(met.payload.index),
                given.payload.tag.tag.eq(met.payload.tag), self.steps[k].eq(steps.o.valid & steps.o.ready),
                *(given.payload.tag[name].eq(met.payload[name]) for name in ("is_cell", "last"))]
        source, made = self._numbers[0].o, self._numbers[0].o.payload
        if self._merge is not None:
            m.submodules.merge = merge = self._merge
            for number, taker in zip(self._numbers, merge.i, strict=True):
                wiring.connect(m, number.o, taker)
            source, made = merge.o, merge.o.payload.item
        m.d.comb += [
            self.o.valid.eq(source.valid), source.ready.eq(self.o.ready), self.o.payload.cell.eq(made.cell),
            self.o.payload.tag.eq(made.tag.tag),
            *(self.o.payload[name].eq(made.tag[name]) for name in ("is_cell", "last"))]
        return m
