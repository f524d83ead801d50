"""Edge planes: the planes through the origin and each edge and diagonal of a patch, exact."""

from amaranth.hdl import Array, Cat, Module, Signal, signed
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import PHASES, IcuFormats
from hw.lib.fixed import split_limbs, total
from hw.lib.pipeline import OPERAND, Pipeline
from hw.lib.struct_stream import struct_stream
from hw.lib.time_multiplexer import TimeMultiplexer

__all__ = ["EdgePlanes"]

# The next two axes after each.
AXES = ((1, 2), (2, 0), (0, 1))


class EdgePlanes(wiring.Component):
    """``n_ij = V'_i x V'_j`` of four edges and two diagonals, and the winding of the patch.

    In phase e six multipliers make the plane of edge e, six more its product with the vertex after it, and three make
    one half of a diagonal's plane: 0-2 in the first two phases, 1-3 in the others.

    Parameters
    ----------
    config
        The configuration.
    interval
        Cycles from a phase to the next one: a fourth of those from a patch to the next one, at least.

    Members
    -------
    i : In, stream of ``slot``, ``directions``, always ready
        V' of the four vertices; at least four intervals apart.
    o_planes : Out, stream of ``slot``, ``part``, always ready
        `IcuFormats.planes`.
    o : Out, stream of ``slot``, ``winding``, ``signs``, always ready
        `IcuFormats.winding` and `IcuFormats.signs`.

    Timing
    ------
    Latency: ``2 * product_registers + 12 if interval == 1 else product_registers + 3 * interval + 21`` cycles to ``o``
    with an interval of 1, or of 15 and more; ``o_planes`` comes earlier. A patch every four intervals; nothing stalls.

    Golden counterpart: `golden.engine.icu.edge_planes.edge_planes`. Source: Shen 1993, section 5.3.5.
    """

    def __init__(self, *, config: Config, interval: int = 1):
        formats, registers = IcuFormats(config), config.icu.product_registers

        patch = StructLayout({"slot": formats.slot, "directions": ArrayLayout(formats.vertex_vector, 4)})
        super().__init__({
            "i": In(stream.Signature(patch, always_ready=True)),
            "o_planes": Out(struct_stream({"slot": formats.slot, "part": formats.planes})),
            "o": Out(struct_stream({"slot": formats.slot, "winding": formats.winding, "signs": formats.signs}))})
        self._phases = TimeMultiplexer(patch, count=PHASES, interval=interval, turned="directions")
        beat = self._phases.o
        # The results of a phase: the signs of its edge's triple product, of its edge's plane and of the diagonal's.
        signs = ArrayLayout(signed(2), 3)
        self._end = stream.Signature(StructLayout({"slot": formats.slot, "phase": 2, "turn": signed(2), "edge": signs,
                                                   "diagonal": signs, "is_triangle": 1}), always_ready=True).create()
        self._pipeline = pipeline = Pipeline(beat, self._end, interval=interval)
        # The first one is the phase's own.
        vertices = beat.payload.item.directions
        phase = pipeline.input(beat.payload.phase)

        def chosen(first):
            """The vertex that follows the phase's own by ``first``."""
            return [pipeline.delay(pipeline.input(vertices[first][axis]), 1) for axis in range(3)]

        def difference(a, b):
            return pipeline.register(lambda a, b: a - b, a, b)

        a, b, c = (chosen(first) for first in range(3))
        plane = [difference(*(pipeline.product(a[j], b[k], registers=registers) for j, k in (axes, axes[::-1])))
                 for axes in AXES]
        # A half: the products of one of the two terms of each component, of vertices 0 and 2, then of 1 and 3.
        half = []
        for j, k in AXES:
            one = pipeline.register(lambda phase, j=j, k=k: Array(
                [vertices[0][j], vertices[3][k], vertices[3][j], vertices[2][k]])[phase], phase)
            other = pipeline.register(lambda phase, j=j, k=k: Array(
                [vertices[2][k], vertices[1][j], vertices[1][k], vertices[0][j]])[phase], phase)
            half.append(pipeline.product(one, other, registers=registers))
        diagonal = [difference(pipeline.before(value, 1), value) for value in half]
        self._planes = pipeline.align(pipeline.input(beat.payload.item.slot), phase, *plane, *diagonal)

        # A plane is so far from the end of its format that the high limb has no bit more than are above the low one.
        limbs = [[pipeline.combine(lambda value, k=k: split_limbs(value, OPERAND)[k][:OPERAND].as_signed(), value)
                  for value in plane] for k in range(2)]
        high, low = (total(pipeline, [pipeline.product(value, vertex, registers=registers)
                                      for value, vertex in zip(limb, c, strict=True)]) for limb in limbs)
        triple = pipeline.register(lambda high, low: (high << OPERAND) + low, high, low)
        pipeline.output(self._end.payload.turn, pipeline.register(_sign, triple))
        pipeline.output(self._end.payload.phase, phase)
        pipeline.output(self._end.payload.slot, pipeline.input(beat.payload.item.slot))
        for axis in range(3):
            pipeline.output(self._end.payload.edge[axis], pipeline.register(_sign, plane[axis]))
            pipeline.output(self._end.payload.diagonal[axis], pipeline.register(_sign, diagonal[axis]))
        # Of the last phase: vertices 2 and 3.
        is_triangle = pipeline.register(
            lambda _: Cat(vertices[3][axis] == vertices[0][axis] for axis in range(3)).all(), phase)
        pipeline.output(self._end.payload.is_triangle, is_triangle)
        self.latency = self._phases.latency + (PHASES - 1) * interval + pipeline.latency + 2

    def elaborate(self, platform):
        m = Module()
        m.submodules.phases = phases = self._phases
        m.d.comb += [phases.i.valid.eq(self.i.valid), phases.i.payload.eq(self.i.payload)]
        # The planes as their phases pass; the next patch begins to overwrite them after they have been sent.
        slot, phase, *values = (value.value for value in self._planes)
        plane, diagonal = values[:3], values[3:]
        passes = self._pipeline.valid(self._planes[0].age)
        planes = self.o_planes.payload.part
        with m.If(passes):
            m.d.sync += self.o_planes.payload.slot.eq(slot)
            with m.Switch(phase):
                for edge in range(PHASES):
                    with m.Case(edge):
                        m.d.sync += [planes[edge][axis].eq(plane[axis]) for axis in range(3)]
                        if edge % 2:
                            m.d.sync += [planes[PHASES + edge // 2][axis].eq(diagonal[axis]) for axis in range(3)]
        m.d.sync += self.o_planes.valid.eq(passes & (phase == PHASES - 1))

        end, done = self._end, Signal()
        winding = Signal(ArrayLayout(signed(2), PHASES))
        signs = Signal.like(self.o.payload.signs)
        with m.If(end.valid), m.Switch(end.payload.phase):
            for edge in range(PHASES):
                with m.Case(edge):
                    m.d.sync += [winding[edge].eq(end.payload.turn), signs[edge].eq(end.payload.edge)]
                    if edge == 1:
                        m.d.sync += signs[PHASES].eq(end.payload.diagonal)
        slot, is_triangle = Signal.like(self.o.payload.slot), Signal()
        convex = (winding[0] != 0) & Cat(winding[edge] == winding[0] for edge in range(1, PHASES)).all()
        m.d.sync += [
            slot.eq(end.payload.slot), is_triangle.eq(end.payload.is_triangle),
            done.eq(end.valid & (end.payload.phase == PHASES - 1)), self.o.valid.eq(done),
            self.o.payload.slot.eq(slot), self.o.payload.signs.eq(signs),
            self.o.payload.winding.split.eq(~convex & ~is_triangle),
            self.o.payload.winding.orientation[0].eq(winding[0]), self.o.payload.winding.orientation[1].eq(winding[2])]
        self._pipeline.add_to(m)
        return m


def _sign(value):
    """-1, 0 or 1."""
    return Cat(value.any(), value[-1]).as_signed()
