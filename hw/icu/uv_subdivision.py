"""(u, v) by bounding-plane subdivision: a patch is cut in halves around the ray, by adders alone."""

from amaranth.hdl import Cat, Module, Mux
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.config import Config
from hw.formats import Formats
from hw.lib.pipeline import Pipeline

__all__ = ["UvSubdivision"]


class UvSubdivision(wiring.Component):
    """One bit of u, one bit of v, and so on: which side of the cut the ray is on, and the distances of that half.

    Parameters
    ----------
    config
        The configuration.
    tag
        Shape of what goes along.

    Members
    -------
    i
        ``tag`` and ``distances`` (`Formats.aligned`), of a ray inside the patch. Always ready.
    o
        ``tag``, ``u`` and ``v``. Always ready.

    Timing
    ------
    Latency: ``6 * uv_bits`` cycles: sums, the cut, the half, for each bit. One ray per cycle; nothing stalls.

    Golden counterpart: `golden.icu.uv_subdivision.uv_subdivision`. Source: Shen 1993, section 5.3.5.
    """

    def __init__(self, *, config: Config, tag):
        formats, icu = Formats(config), config.icu
        super().__init__({
            "i": In(stream.Signature(StructLayout({"tag": tag, "distances": formats.aligned}), always_ready=True)),
            "o": Out(stream.Signature(StructLayout({"tag": tag, "u": formats.uv, "v": formats.uv}),
                                      always_ready=True))})
        self._pipeline = pipeline = Pipeline(self.i, self.o)
        width = formats.aligned_width
        distances = [pipeline.input(self.i.payload.distances[edge]) for edge in range(6)]
        u, v = [], []

        def summed(a, b):
            return pipeline.register(lambda a, b: a + b, a, b)

        def difference(a, b):
            return pipeline.register(lambda a, b: a - b, a, b)

        def half(value):
            return pipeline.combine(lambda value: value >> 1, value)

        def pick(condition, yes, no):
            return pipeline.register(lambda condition, yes, no: Mux(condition, yes, no)[:width].as_signed(),
                                     condition, yes, no)

        def negative(value):
            return pipeline.combine(lambda value: -value, value)

        for _ in range(icu.uv_bits):
            d01, d12, d23, d30, d02, d13 = distances
            one, other = difference(d13, d30), summed(d02, d12)
            cut = pipeline.register(lambda a, b: (a + b) >> 2, one, other)
            left = pipeline.combine(lambda cut: ~cut[-1], cut)
            distances = [half(d01), pick(left, cut, d12), half(d23), pick(left, d30, negative(cut)),
                         pick(left, half(difference(d02, d30)), half(other)),
                         pick(left, half(one), half(summed(d13, d12)))]
            u.append(pipeline.combine(lambda left: ~left, left))

            d01, d12, d23, d30, d02, d13 = distances
            one, other = summed(d01, d02), summed(d13, d23)
            cut = pipeline.register(lambda a, b: (a - b) >> 2, one, other)
            lower = pipeline.combine(lambda cut: cut[-1] | ~cut.any(), cut)
            distances = [pick(lower, d01, cut), half(d12), pick(lower, negative(cut), d23), half(d30),
                         pick(lower, half(one), half(difference(d02, d23))),
                         pick(lower, half(difference(d13, d01)), half(other))]
            v.append(pipeline.combine(lambda lower: ~lower, lower))

        # The last halves are nobody's.
        for target, bits in ((self.o.payload.u, u), (self.o.payload.v, v)):
            pipeline.output(target, pipeline.register(lambda *bits: Cat(reversed(bits)), *bits))
        pipeline.output(self.o.payload.tag, pipeline.input(self.i.payload.tag))
        self.latency = pipeline.latency

    def elaborate(self, platform):
        m = Module()
        self._pipeline.add_to(m)
        return m
