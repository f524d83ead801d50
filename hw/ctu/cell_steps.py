"""Cell steps: many grid rays go round, and each passes into its next cell once per round."""

from itertools import pairwise

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from golden.engine.ctu.cell_traversal import NEVER
from hw.ctu.ctu_formats import CtuFormats
from hw.lib.skid_buffer import SkidBuffer

__all__ = ["CellSteps"]

# Registers that a ray passes in a round: it enters, borders are compared, the nearest is chosen, the ray moves, and its
# new cell is checked.
STAGES = 5


class CellSteps(wiring.Component):
    """``t = min(next)``; on each axis with ``next = t`` the cell is the next one and ``next`` grows by ``between``.

    A ray is done when t reaches the end of its shell, or outside the grid for good. Rays go round a ring of registers
    and enter it where there is a gap.

    Parameters
    ----------
    config
        The configuration.
    tag
        Shape of the sideband.

    Members
    -------
    i : In, stream of ``tag``, ``walk``
        Rays (`CtuFormats.walk`).
    o : Out, stream of ``tag``, ``index``, ``is_cell``, ``last``
        Cells: whether one is in the grid, and the last item of its ray.
    shape : In, array of 3
        Cells along each axis; constant while rays are in flight.

    Timing
    ------
    Latency: ``6`` cycles to a ray's first cell, its next ones 5 apart. One cell of any ray per cycle, with 5 rays in
    flight or more waiting; stalls while a cell waits, and a register enables all others of the ring.

    Golden counterpart: `golden.engine.ctu.cell_traversal.Traversal.advance`. Source: Shen 1993, section 5.3.4.5.
    """

    def __init__(self, *, config: Config, tag):
        formats = self._formats = CtuFormats(config)
        self._item = StructLayout({"tag": tag, "walk": formats.walk})
        super().__init__({
            "i": In(stream.Signature(self._item)),
            "o": Out(stream.Signature(StructLayout({"tag": tag, "index": ArrayLayout(formats.grid_index, 3),
                                                    "is_cell": 1, "last": 1}))),
            "shape": In(ArrayLayout(formats.grid_count, 3))})
        self._skid = SkidBuffer(self.o.payload.shape())
        self.latency = STAGES + self._skid.latency

    def elaborate(self, platform):
        m = Module()
        formats, axes = self._formats, range(3)
        # What all registers of the ring depend on, and whether the ray at its end stays, are known before.
        moves, stays = Signal(init=1), Signal()
        valid = [Signal(name=f"valid_{stage}") for stage in range(STAGES)]
        rays = [Signal(self._item, name=f"ray_{stage}", reset_less=True) for stage in range(STAGES)]
        entered, compared, chosen, moved, judged = (ray.walk for ray in rays)

        # Which borders do not come after which others; of the nearest ones its parameter and axes.
        pairs = [(a, b) for a in axes for b in axes if a != b]
        not_after = {(a, b): Signal(name=f"not_after_{a}_{b}", reset_less=True) for a, b in pairs}
        crosses = Cat(Cat(not_after[pair] for pair in pairs if pair[0] == axis).all() for axis in axes)
        nearest, crossed = Signal(formats.parameter, reset_less=True), Signal(3, reset_less=True)
        # Behind them.
        index = Signal(chosen.index.shape(), reset_less=True)
        following = Signal(ArrayLayout(len(nearest) + 1, 3), reset_less=True)
        ends = Signal(reset_less=True)
        below = Cat(index[axis][-1] for axis in axes)
        above = Cat(~index[axis][-1] & (index[axis] >= self.shape[axis]) for axis in axes)
        away = ((below & ~moved.up) | (above & ~moved.down)).any()
        # What is said of the cell that the ray leaves.
        cell = Signal(chosen.index.shape(), reset_less=True)
        is_cell, goes_on = Signal(reset_less=True), Signal(reset_less=True)

        m.submodules.skid = skid = self._skid
        wiring.connect(m, skid.o, wiring.flipped(self.o))
        out, continues = skid.i.payload, ~ends & ~away & ~moved.away
        m.d.sync += moves.eq(skid.ready_next | ~Mux(moves, valid[-2], valid[-1]))
        m.d.comb += [
            self.i.ready.eq(moves & ~stays), skid.i.valid.eq(valid[-1]), out.tag.eq(rays[-1].tag), out.index.eq(cell),
            out.is_cell.eq(is_cell), out.last.eq(~goes_on)]
        with m.If(moves):
            for source, target in pairwise(range(STAGES)):
                m.d.sync += [valid[target].eq(valid[source]), rays[target].eq(rays[source])]
            m.d.sync += [valid[0].eq(self.i.valid | stays), rays[0].eq(Mux(stays, rays[-1], self.i.payload)),
                         stays.eq(valid[-2] & continues)]
            m.d.sync += [not_after[a, b].eq(entered.next[a] <= entered.next[b]) for a, b in pairs]
            m.d.sync += [
                crossed.eq(crosses),
                nearest.eq(Mux(crosses[0], compared.next[0], Mux(crosses[1], compared.next[1], compared.next[2])))]
            m.d.sync += ends.eq(nearest >= chosen.length)
            for axis in axes:
                m.d.sync += [
                    index[axis].eq(chosen.index[axis] + (chosen.up[axis] & crossed[axis])
                                   - (chosen.down[axis] & crossed[axis])),
                    following[axis].eq(chosen.next[axis] + Mux(crossed[axis], chosen.between[axis], 0)),
                    judged.next[axis].eq(Mux(following[axis][-1], NEVER, following[axis][:-1]))]
            m.d.sync += [
                judged.index.eq(index), judged.inside.eq(~(below | above).any()), judged.away.eq(away),
                cell.eq(moved.index), is_cell.eq(moved.inside & ~moved.away),
                goes_on.eq(continues)]
        return m
