"""G2R transform: vertices from scene coordinates to the frustum's R frame."""

from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import IcuFormats
from hw.lib.fixed import round_shift, split_limbs, total
from hw.lib.pipeline import OPERAND, Pipeline
from hw.lib.struct_stream import struct_stream

__all__ = ["G2rTransform"]



class G2rTransform(wiring.Component):
    """``V = matrix (P - origin)``, one rounding per component.

    The offset is two limbs, so that each product fits one DSP block.

    Parameters
    ----------
    config
        The configuration.
    interval
        Cycles from a vertex to the next one, at least.

    Members
    -------
    i : In, stream of ``slot``, ``index``, ``vertex``, always ready
        Vertex 0 to 3 of a patch in scene coordinates.
    o : Out, stream of ``slot``, ``index``, ``vertex``, always ready
        The same in the R frame.
    frustum : In, `Formats.frustum`
        Stable while vertices are in flight.

    Timing
    ------
    Latency: ``product_registers + 4 + min(18, interval)`` cycles. One vertex per ``interval`` cycles; nothing stalls.

    Golden counterpart: `golden.engine.icu.g2r_transform.g2r_transform`. Source: Shen 1993, section 5.3.5.
    """

    def __init__(self, *, config: Config, interval: int = 1):
        formats, numbers = IcuFormats(config), config.numbers

        vertex = {"slot": formats.slot, "index": 2}
        super().__init__({
            "i": In(struct_stream({**vertex, "vertex": formats.scene_vector})),
            "o": Out(struct_stream({**vertex, "vertex": formats.vector_vector})),
            "frustum": In(formats.frustum)})
        self._pipeline = pipeline = Pipeline(self.i, self.o, interval=interval)
        given, made = self.i.payload, self.o.payload
        offset = [pipeline.register(lambda a, b: a - b, pipeline.input(given.vertex[axis]),
                                    pipeline.constant(self.frustum.origin[axis])) for axis in range(3)]
        limbs = [[pipeline.combine(lambda value, k=k: split_limbs(value, OPERAND)[k], value) for k in range(2)]
                 for value in offset]
        lost = numbers.scene_bits + numbers.direction_fraction - numbers.vector_fraction
        for row in range(3):
            high, low = (total(pipeline, [
                pipeline.product(limbs[axis][k], pipeline.constant(self.frustum.matrix[row][axis]),
                                 registers=config.icu.product_registers) for axis in range(3)]) for k in range(2))
            whole = pipeline.register(lambda high, low: (high << OPERAND) + low, high, low)
            vertex = pipeline.register(lambda value: round_shift(value, lost), whole)
            pipeline.output(made.vertex[row], vertex)
        for name in ("slot", "index"):
            pipeline.output(made[name], pipeline.input(given[name]))
        self.latency = pipeline.latency

    def elaborate(self, platform):
        return self._pipeline.module()
