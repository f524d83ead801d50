"""(u, v) by bounding-plane subdivision: a patch is cut in halves around the ray, by adders alone."""

from amaranth.hdl import Cat, Const, Mux
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import IcuFormats
from hw.lib.fixed import add_or_subtract
from hw.lib.pipeline import Pipeline

__all__ = ["UvSubdivision"]


class UvSubdivision(wiring.Component):
    """One bit of u, one bit of v, and so on: which side of the cut the ray is on, and the distances of that half.

    Parameters
    ----------
    config
        The configuration.
    tag
        Shape of the sideband data.

    Members
    -------
    i : In, stream of ``tag``, ``distances``, always ready
        `IcuFormats.aligned` of a ray inside the patch.
    o : Out, stream of ``tag``, ``u``, ``v``, always ready
        `IcuFormats.uv` each.

    Timing
    ------
    Latency: ``6 * uv_bits`` cycles: sums, the cut, the half, for each bit. One ray per cycle; nothing stalls.

    Golden counterpart: `golden.engine.icu.uv_subdivision.uv_subdivision`. Source: Shen 1993, section 5.3.5.
    """

    def __init__(self, *, config: Config, tag):
        formats, icu = IcuFormats(config), config.icu
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

        def halved(value, yes, no, condition, subtract):
            """Half of ``value`` and another number, which is subtracted or added: one adder that also chooses."""
            return pipeline.register(lambda value, yes, no, condition, subtract: add_or_subtract(
                value, Mux(condition, yes, no).as_signed(), subtract)[1:width + 1].as_signed(),
                value, yes, no, condition, subtract)

        def pick(condition, yes, no):
            return pipeline.register(lambda condition, yes, no: Mux(condition, yes, no).as_signed(), condition, yes, no)

        def pick_negative(condition, kept, cut):
            """``kept``, or ``-cut``."""
            return pipeline.register(lambda condition, kept, cut: add_or_subtract(
                Const(0, 1).as_signed(), Mux(condition, kept, cut).as_signed(), ~condition)[:width].as_signed(),
                condition, kept, cut)

        for _ in range(icu.uv_bits):
            d01, d12, d23, d30, d02, d13 = distances
            cut = pipeline.register(lambda a, b: ((a + b) >> 2)[:width].as_signed(), difference(d13, d30),
                                    summed(d02, d12))
            left = pipeline.combine(lambda cut: ~cut[-1], cut)
            distances = [half(d01), pick(left, cut, d12), half(d23), pick_negative(left, d30, cut),
                         halved(d02, d30, d12, left, left), halved(d13, d30, d12, left, left)]
            u.append(pipeline.combine(lambda left: ~left, left))

            d01, d12, d23, d30, d02, d13 = distances
            one, other = summed(d01, d02), summed(d13, d23)
            cut = pipeline.register(lambda a, b: ((a - b) >> 2)[:width].as_signed(), one, other)
            # The cut is at most 0, as a sign, for which no bit of it need be gathered.
            lower = pipeline.register(lambda a, b: (a - b - 4)[-1], one, other)
            upper = pipeline.combine(lambda lower: ~lower, lower)
            distances = [pick(lower, d01, cut), half(d12), pick_negative(upper, d23, cut), half(d30),
                         halved(d02, d01, d23, lower, upper), halved(d13, d01, d23, lower, lower)]
            v.append(upper)

        # The distances of the last halves are not used.
        for target, bits in ((self.o.payload.u, u), (self.o.payload.v, v)):
            pipeline.output(target, pipeline.register(lambda *bits: Cat(reversed(bits)), *bits))
        pipeline.output(self.o.payload.tag, pipeline.input(self.i.payload.tag))
        self.latency = pipeline.latency

    def elaborate(self, platform):
        return self._pipeline.module()
