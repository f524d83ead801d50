"""UV alignment: the distances of a ray from a patch's edges and diagonals, brought to one exponent."""

from amaranth.hdl import Cat, Const, Mux
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import IcuFormats
from hw.icu.icu_tables import EDGES
from hw.lib.fixed import extreme, magnitude, normalise, shift_right, with_sign
from hw.lib.pipeline import Pipeline

__all__ = ["UvAlignment"]


class UvAlignment(wiring.Component):
    """Each V' has an exponent of its own, and n_ij the sum of two. The largest distance gets 2 ``uv_bits`` +
    ``uv_guard`` bits, the others are rounded to its unit; all are turned by the orientation.

    Parameters
    ----------
    config
        The configuration.
    tag
        Shape of the sideband data.

    Members
    -------
    i : In, stream of ``tag``, ``distances``, ``orientation``, ``exponents``, always ready
        Distances of a ray, and the exponents of the four V'.
    o : Out, stream of ``tag``, ``distances``, always ready
        `IcuFormats.aligned`.

    Timing
    ------
    Latency: ``bits(2 * vertex_bits + direction_fraction + 2) + (bits(2 * uv_bits + uv_guard + 1) + 1) // 2 + 8``
    cycles, ``bits(n)`` those of the number n. One ray per cycle; nothing stalls.

    Golden counterpart: `golden.engine.icu.uv_subdivision.align`.
    """

    def __init__(self, *, config: Config, tag):
        formats, numbers, icu = IcuFormats(config), config.numbers, config.icu
        super().__init__({
            "i": In(stream.Signature(StructLayout({
                "tag": tag, "distances": ArrayLayout(formats.edge_distance, 6), "orientation": formats.orientation,
                "exponents": ArrayLayout(formats.vertex_exponent, 4)}), always_ready=True)),
            "o": Out(stream.Signature(StructLayout({"tag": tag, "distances": formats.aligned}), always_ready=True))})
        self._pipeline = pipeline = Pipeline(self.i, self.o)
        given = self.i.payload
        # One bit behind the unit decides how a distance is rounded.
        kept, width = 2 * icu.uv_bits + icu.uv_guard + 1, numbers.edge_distance.width - 1
        leading, sizes = [], []
        for edge, (first, second) in enumerate(EDGES):
            scale = pipeline.register(lambda a, b: a + b, pipeline.input(given.exponents[first]),
                                      pipeline.input(given.exponents[second]))
            distance = pipeline.register(magnitude, pipeline.input(given.distances[edge]))
            (value,), empty = normalise(pipeline, width, [distance])
            value = pipeline.combine(lambda value: Cat(Const(0, max(0, kept - width)), value)[-kept:], value)
            size = pipeline.register(lambda scale, empty: scale - empty, scale, empty)
            # Zero has no size.
            least = -(1 << len(size.value) - 1)
            sizes.append(pipeline.combine(
                lambda size, value, least=least: Mux(value[-1], size, least).as_signed(), size, value))
            leading.append(value)
        top = extreme(pipeline, sizes, largest=True)
        steps = kept.bit_length()
        for edge, (value, size) in enumerate(zip(leading, sizes, strict=True)):
            behind = pipeline.register(
                lambda top, size: Mux(top - size >= 1 << steps, (1 << steps) - 1, (top - size)[:steps]), top, size)
            value = shift_right(pipeline, value, behind, kept)
            near = pipeline.register(lambda value: (value + 1) >> 1, value)
            negative = pipeline.combine(lambda value, turn: value[-1] ^ turn[-1],
                                        pipeline.input(given.distances[edge]), pipeline.input(given.orientation))
            pipeline.output(self.o.payload.distances[edge], pipeline.register(with_sign, near, negative))
        pipeline.output(self.o.payload.tag, pipeline.input(given.tag))
        self.latency = pipeline.latency

    def elaborate(self, platform):
        return self._pipeline.module()
