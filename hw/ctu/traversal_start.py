"""Traversal start: where a grid ray is when its shell begins, and how far the next cell borders are."""

from amaranth.hdl import Cat, Const, Module, Mux
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from golden.engine.ctu.cell_traversal import (
    GUARD,
    NEVER,
    PARAMETER_BITS,
    POSITION_FRACTION,
    RECIPROCAL_BITS,
    ROW_BITS,
    reciprocal_table,
)
from golden.engine.ctu.grid_rays import FRACTION
from hw.ctu.ctu_formats import CtuFormats
from hw.lib.fixed import magnitude, normalise, shift_right, small_product
from hw.lib.pipeline import Pipeline
from hw.lib.skid_buffer import SkidBuffer

__all__ = ["TraversalStart"]

# Bits of an operand of a multiplier that are never negative.
LIMB = 17


class TraversalStart(wiring.Component):
    """``position = origin + direction begin``, and for each axis the parameters ``distance / |direction|`` to the next
    border and ``1 / |direction|`` from there to the one after it.

    The reciprocal is one of a table with a slope; a component of 0 has one that is never reached.

    Parameters
    ----------
    config
        The configuration.
    tag
        Shape of the sideband.

    Members
    -------
    i : In, stream of ``tag``, ``direction``, ``begin``, ``length``
        A ray: its direction in G (`CtuFormats.grid_direction`), and its shell.
    o : Out, stream of ``tag``, ``walk``
        The ray at the beginning of its shell (`CtuFormats.walk`).
    origin, shape : In, arrays of 3
        The frustum's origin in cells and the grid's cells along each axis; constant while rays are in flight.

    Timing
    ------
    Latency: ``product_registers + 21`` cycles. One ray per cycle; stalls while the ray at the end waits, and a
    register enables all others.

    Golden counterpart: `golden.engine.ctu.cell_traversal.traversal_start`. Source: Shen 1993, section 5.3.4.5.
    """

    def __init__(self, *, config: Config, tag):
        formats = CtuFormats(config)
        self._registers = config.icu.product_registers
        super().__init__({
            "i": In(stream.Signature(StructLayout({"tag": tag, **formats.grid_ray.members}))),
            "o": Out(stream.Signature(StructLayout({"tag": tag, "walk": formats.walk}))),
            "origin": In(ArrayLayout(formats.grid_coordinate, 3)), "shape": In(ArrayLayout(formats.grid_count, 3))})
        # Of a row the value is stored as what it lacks of the largest one.
        value, slope = reciprocal_table()
        self._row = StructLayout({"lacks": RECIPROCAL_BITS + GUARD - 1, "slope": int(slope.max()).bit_length()})
        self._rows = [{"lacks": (1 << RECIPROCAL_BITS + GUARD) - int(v), "slope": int(s)}
                      for v, s in zip(value, slope, strict=True)]
        self._memories = []
        self._skid = SkidBuffer(self.o.payload.shape())
        self._pipeline = pipeline = Pipeline(self.i, self._skid.i, ready_next=self._skid.ready_next)
        given, walk = self.i.payload, self._skid.i.payload.walk
        begin = pipeline.input(given.begin)
        lost = []
        for axis in range(3):
            direction = pipeline.input(given.direction[axis])
            index, within, far = self._position(direction, begin, self.origin[axis])
            lacking, by = self._mantissa(direction)
            up = pipeline.combine(lambda value: ~value[-1] & value.any(), direction)
            down = pipeline.combine(lambda value: value[-1], direction)
            still = pipeline.combine(lambda value: ~value.any(), direction)
            distance = pipeline.register(
                lambda up, within: Mux(up, (1 << POSITION_FRACTION) - within, within)[:POSITION_FRACTION + 1],
                up, within)
            shift = pipeline.register(lambda by: (RECIPROCAL_BITS + 3 - by)[:5], by)
            low = pipeline.combine(lambda value: value[:LIMB], lacking)
            high = pipeline.combine(lambda value: Cat(value[LIMB:], 0).as_signed(), lacking)
            product = self._product(low, distance)
            more = small_product(pipeline, high, pipeline.combine(lambda value: Cat(value, 0).as_signed(), distance))
            whole = pipeline.register(lambda a, b: (a + (b << LIMB))[:RECIPROCAL_BITS + POSITION_FRACTION + 2], product,
                                      more)
            wide = pipeline.combine(lambda value: Cat(Const(0, POSITION_FRACTION), value), lacking)
            for name, value in (("next", whole), ("between", wide)):
                pipeline.output(walk[name][axis], self._parameter(value, shift, still))
            pipeline.output(walk.index[axis], index)
            pipeline.output(walk.up[axis], up)
            pipeline.output(walk.down[axis], down)
            over = pipeline.combine(lambda index, axis=axis: index >= self.shape[axis], index)
            lost.append(pipeline.register(
                lambda index, over, up, down, far: (index[-1] & ~up) | (~index[-1] & over & ~down) | far,
                index, over, up, down, far))
            lost.append(pipeline.register(lambda index, over: index[-1] | over, index, over))
        pipeline.output(walk.away, pipeline.combine(lambda *each: Cat(each).any(), *lost[::2]))
        pipeline.output(walk.inside, pipeline.combine(lambda *each: ~Cat(each).any(), *lost[1::2]))
        pipeline.output(walk.length, pipeline.input(given.length))
        pipeline.output(self._skid.i.payload.tag, pipeline.input(given.tag))
        self.latency = pipeline.latency + self._skid.latency

    def elaborate(self, platform):
        m = Module()
        for axis, memory in enumerate(self._memories):
            m.submodules[f"table_{axis}"] = memory
        self._pipeline.add_to(m)
        m.submodules.skid = self._skid
        wiring.connect(m, self._skid.o, wiring.flipped(self.o))
        return m

    def _product(self, a, b):
        return self._pipeline.product(a, b, registers=self._registers)

    def _position(self, direction, begin, origin):
        """A component of the position: cell, where in it, and whether the cell's number does not fit."""
        pipeline, half = self._pipeline, len(begin.value) // 2
        low = pipeline.combine(lambda value: value[:LIMB], direction)
        high = pipeline.combine(lambda value: value[LIMB:].as_signed(), direction)
        first = self._product(low, pipeline.combine(lambda value: value[:half], begin))
        second = self._product(low, pipeline.combine(lambda value: value[half:], begin))
        third = small_product(pipeline, high, pipeline.combine(lambda value: Cat(value, 0).as_signed(), begin))
        # What is cut off below the point of a position never carries.
        upper = pipeline.register(lambda first, second: (first >> half) + second, first, second)
        offset = pipeline.register(
            lambda upper, third: (upper + (third << LIMB - half)) >> FRACTION - half, upper, third)
        position = pipeline.register(lambda offset: origin + offset, offset)
        width = len(self.o.payload.walk.index[0])
        index = pipeline.combine(
            lambda position: position[POSITION_FRACTION:POSITION_FRACTION + width].as_signed(), position)
        rest = pipeline.combine(lambda position: position[POSITION_FRACTION + width - 1:], position)
        far = pipeline.register(lambda rest: rest.any() & ~rest.all(), rest)
        return index, pipeline.combine(lambda position: position[:POSITION_FRACTION], position), far

    def _mantissa(self, direction):
        """Of the reciprocal, and by how much the magnitude was shifted to the left for it."""
        pipeline = self._pipeline
        (normal,), by = normalise(pipeline, RECIPROCAL_BITS, [pipeline.register(magnitude, direction)])
        rest = RECIPROCAL_BITS - 1 - ROW_BITS
        self._memories.append(Memory(shape=self._row, depth=1 << ROW_BITS, init=self._rows))
        row = pipeline.delay(pipeline.read(self._memories[-1].read_port(), pipeline.combine(
            lambda value: value[rest:rest + ROW_BITS], normal)), 1)
        slope = pipeline.combine(lambda row: row.slope, row)
        down = self._product(slope, pipeline.combine(lambda value: value[:rest], normal))
        lacks = pipeline.combine(lambda row: row.lacks, row)
        lacks = pipeline.register(lambda lacks, down: lacks + (down >> rest), lacks, down)
        return pipeline.register(
            lambda lacks: (((1 << RECIPROCAL_BITS + GUARD) - lacks) >> GUARD)[:RECIPROCAL_BITS + 1], lacks), by

    def _parameter(self, value, shift, still):
        """``value / 2^shift``, at most `NEVER`."""
        pipeline = self._pipeline
        shifted = shift_right(pipeline, value, shift, len(value.value))
        return pipeline.register(
            lambda shifted, still: Mux(still | shifted[PARAMETER_BITS:].any(), NEVER, shifted[:PARAMETER_BITS]),
            shifted, still)
