"""Vertex direction: V' = V with short magnitudes, each vertex by its own leading zeros."""

from amaranth.hdl import Cat, Const, Mux
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import IcuFormats
from hw.lib.fixed import magnitude, normalise, with_sign
from hw.lib.pipeline import Pipeline

__all__ = ["VertexDirection"]


class VertexDirection(wiring.Component):
    """``V' 2^exponent`` is V with magnitudes of ``vertex_bits`` bits, rounded to nearest, half away from zero.

    What would round up to 2^``vertex_bits`` becomes 2^``vertex_bits`` - 1.

    Parameters
    ----------
    config
        The configuration.
    interval
        Cycles from a vertex to the next one, at least.

    Members
    -------
    i : In, stream of ``slot``, ``index``, ``vertex``, always ready
        A vertex in the R frame.
    o : Out, stream of ``slot``, ``index``, ``vertex``, ``direction``, ``exponent``, always ready
        The same vertex, its V' and the exponent of V'.

    Timing
    ------
    Latency: ``4 + bits(max(vector_fraction, vertex_bits - 1))`` cycles, ``bits(n)`` those of the number n. One vertex
    per ``interval`` cycles; nothing stalls.

    Golden counterpart: `golden.engine.icu.vertex_direction.vertex_direction`.
    """

    def __init__(self, *, config: Config, interval: int = 1):
        formats, numbers = IcuFormats(config), config.numbers
        item = {"slot": formats.slot, "index": 2, "vertex": formats.vector_vector}
        super().__init__({
            "i": In(stream.Signature(StructLayout(item), always_ready=True)),
            "o": Out(stream.Signature(StructLayout({**item, "direction": formats.vertex_vector,
                                                    "exponent": formats.vertex_exponent}), always_ready=True))})
        self._pipeline = pipeline = Pipeline(self.i, self.o, interval=interval)
        given, made = self.i.payload, self.o.payload
        bits = numbers.vertex_bits
        width = max(numbers.vector.width - 1, bits)
        vertex = [pipeline.input(given.vertex[axis]) for axis in range(3)]
        size = [pipeline.register(magnitude, component) for component in vertex]
        shifted, by = normalise(pipeline, width, size)

        def rounded(value):
            cut = width - bits
            near = value + (1 << cut - 1) if cut else value
            return Mux(near >> cut == 1 << bits, Const((1 << bits) - 1, bits), (near >> cut)[:bits])

        for axis in range(3):
            near = pipeline.register(rounded, shifted[axis])
            negative = pipeline.combine(lambda value: value[-1], vertex[axis])
            pipeline.output(made.direction[axis], pipeline.register(with_sign, near, negative))
        # Of the vertex (0, 0, 0) as if it had no bit at all.
        largest = pipeline.combine(lambda *values: Cat(value[-1] for value in values).any(), *shifted)
        exponent = pipeline.register(lambda by, some: Mux(some, width - bits - by, -bits), by, largest)
        pipeline.output(made.exponent, exponent)
        pipeline.output(made.vertex, pipeline.input(given.vertex))
        for name in ("slot", "index"):
            pipeline.output(made[name], pipeline.input(given[name]))
        self.latency = pipeline.latency

    def elaborate(self, platform):
        return self._pipeline.module()
