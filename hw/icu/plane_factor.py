"""Plane factor: m = N/V, of which m . d is a ray's inverse distance to the plane of a patch."""

from amaranth.hdl import Array, Cat, Const, Module, Mux
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import PHASES, IcuFormats
from hw.icu.icu_tables import GUARD, NEAREST_PLANE
from hw.lib.fixed import normalise, split_limbs, total
from hw.lib.pipeline import OPERAND, Pipeline
from hw.lib.reciprocal import Reciprocal
from hw.lib.struct_stream import struct_stream
from hw.lib.time_multiplexer import TimeMultiplexer

__all__ = ["PlaneFactor"]

AXES = ((1, 2), (2, 0), (0, 1))


class PlaneFactor(wiring.Component):
    """``N = (V_2 - V_0) x (V_3 - V_1)``, ``V = N . V_0``, both exact, and ``m = N/V`` rounded.

    Three pipelines and the division between them, each working on a patch in four phases: six DSP blocks for N,
    six for V, three for the product of N and 1/V.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of ``slot``, ``vertices``, always ready
        Four vertices in the R frame; at least four cycles apart.
    o : Out, stream of ``slot``, ``part``, always ready
        `IcuFormats.factor`.

    Timing
    ------
    Latency: ``3 * product_registers + 4 * ((mantissa_bits + 5) // 4) + bits(3 * vector_fraction + 7) + 30`` cycles,
    ``bits(n)`` those of the number n. A patch every four cycles; nothing stalls.

    Golden counterpart: `golden.engine.icu.plane_factor.plane_factor`.
    """

    def __init__(self, *, config: Config):
        formats = IcuFormats(config)
        self._config = config

        patch = StructLayout({"slot": formats.slot, "vertices": ArrayLayout(formats.vector_vector, 4)})
        super().__init__({"i": In(stream.Signature(patch, always_ready=True)),
                          "o": Out(struct_stream({"slot": formats.slot, "part": formats.factor}))})
        self._normal_width = config.numbers.plane_normal.width
        normal = StructLayout({"slot": formats.slot, "normal": ArrayLayout(formats.plane_normal, 3),
                               "vertex": formats.vector_vector})
        bits = config.numbers.mantissa_bits + GUARD
        self._bits = bits
        self._rest = StructLayout({"slot": formats.slot, "normal": ArrayLayout(bits, 3), "negative": 3, "dropped": 1,
                                   "exponent": formats.factor_exponent})
        self._normals = stream.Signature(normal, always_ready=True).create()
        self._leading = struct_stream({"tag": self._rest, "mantissa": bits}).create()
        self._first, self._second = TimeMultiplexer(patch, count=PHASES), TimeMultiplexer(normal, count=PHASES)
        self._reciprocal = Reciprocal(width=bits, tag=self._rest)
        self._third = TimeMultiplexer(StructLayout({"tag": self._rest, "inverse": bits}), count=PHASES)
        self._pipelines = [self._make_normal(), self._make_leading(), self._make_factor()]
        self.latency = sum(3 * [1 + PHASES - 1]) + sum(pipeline.latency for pipeline in self._pipelines) \
            + self._reciprocal.latency

    def elaborate(self, platform):
        m = Module()
        m.submodules.first, m.submodules.second, m.submodules.third = self._first, self._second, self._third
        m.submodules.reciprocal = self._reciprocal
        wiring.connect(m, wiring.flipped(self.i), self._first.i)
        m.d.comb += [
            self._second.i.valid.eq(self._normals.valid), self._second.i.payload.eq(self._normals.payload),
            self._reciprocal.i.valid.eq(self._leading.valid), self._reciprocal.i.payload.eq(self._leading.payload),
            self._third.i.valid.eq(self._reciprocal.o.valid), self._third.i.payload.eq(self._reciprocal.o.payload)]
        for pipeline in self._pipelines:
            pipeline.add_to(m)
        return m

    def _phased(self, phases, o):
        """A pipeline behind ``phases`` that lets the last phase out; its item and its phase."""
        pipeline = Pipeline(phases.o, o)
        phase = pipeline.input(phases.o.payload.phase)
        pipeline.keep(pipeline.combine(lambda phase: phase == PHASES - 1, phase))
        return pipeline, phases.o.payload.item, phase

    def _product(self, pipeline, a, b):
        return pipeline.product(a, b, registers=self._config.icu.product_registers)

    def _make_normal(self):
        """N: in each phase one limb of each diagonal."""
        pipeline, item, phase = self._phased(self._first, self._normals)
        vertex = item.vertices

        def limb(which, axis, bit):
            """A limb of a component of the diagonal from vertex ``which`` to the one two further on."""
            diagonal = pipeline.register(lambda a, b: a - b, pipeline.input(vertex[which + 2][axis]),
                                         pipeline.input(vertex[which][axis]))
            return pipeline.register(lambda value, phase: Mux(phase[bit], *split_limbs(value, OPERAND)).as_signed(),
                                     diagonal, phase)

        first = [limb(0, axis, 0) for axis in range(3)]
        second = [limb(1, axis, 1) for axis in range(3)]
        for axis, (j, k) in enumerate(AXES):
            part = pipeline.register(lambda a, b: a - b, self._product(pipeline, first[j], second[k]),
                                     self._product(pipeline, first[k], second[j]))
            low, *middle, high = (pipeline.before(part, PHASES - 1 - count) for count in range(PHASES))
            middle = pipeline.register(lambda a, b: (a + b) << OPERAND, *middle)
            outer = pipeline.register(lambda low, high: low + (high << 2 * OPERAND), low, high)
            pipeline.output(self._normals.payload.normal[axis], pipeline.register(lambda a, b: a + b, middle, outer))
        pipeline.output(self._normals.payload.slot, pipeline.input(item.slot))
        pipeline.output(self._normals.payload.vertex, pipeline.input(vertex[0]))
        return pipeline

    def _make_leading(self):
        """V: in phase p limb p of N. Then the leading bits of N and V, and what else is known of m."""
        numbers, bits = self._config.numbers, self._bits
        pipeline, item, phase = self._phased(self._second, self._leading)
        width, tag = self._normal_width, self._leading.payload.tag
        # N has zeros below its own bits where they are fewer than its leading ones.
        span = max(width - 1, bits)
        terms = [[], []]
        for axis in range(3):
            low, rest = OPERAND, item.normal[axis]
            limbs = []
            for _ in range(2):
                rest, low = split_limbs(rest, OPERAND)
                limbs.append(low)
            limbs = Array([*limbs, rest, Const(0, OPERAND).as_signed()])
            limb = pipeline.register(lambda phase, limbs=limbs: limbs[phase], phase)
            for terms_of, part in zip(terms, split_limbs(item.vertex[axis], OPERAND)[::-1], strict=True):
                vertex = pipeline.register(lambda _, part=part: part, phase)
                terms_of.append(self._product(pipeline, limb, vertex))
        low, high = (total(pipeline, terms_of) for terms_of in terms)
        whole = pipeline.register(lambda low, high: low + (high << OPERAND), low, high)
        first, second, third = (pipeline.before(whole, PHASES - 1 - count) for count in range(3))
        upper = pipeline.register(lambda a, b: (a >> OPERAND) + b, first, second)
        upper = pipeline.register(lambda a, b: Cat(a[:OPERAND], (a >> OPERAND) + b).as_signed(), upper, third)
        triple = pipeline.combine(lambda low, upper: Cat(low[:OPERAND], upper).as_signed(), first, upper)
        # N . V_0 in its own units has no more bits than the sizes of N and of a vertex together.
        size = width + numbers.vector.width
        negative = pipeline.combine(lambda value: value[-1], triple)
        distance = pipeline.register(lambda value: _absolute(value)[:size], triple)

        normal = [pipeline.register(_absolute, pipeline.input(item.normal[axis])) for axis in range(3)]
        extent = pipeline.combine(lambda value: value * Const(NEAREST_PLANE), total(pipeline, normal))
        dropped = pipeline.register(lambda distance, extent: distance <= extent, distance, extent)

        (leading,), empty = normalise(pipeline, size, [distance])
        shifted, short = normalise(pipeline, span, normal)
        pipeline.output(self._leading.payload.mantissa, pipeline.combine(
            lambda value: value[-bits:] | (1 << bits - 1), leading))
        # N is in units of 2^-2f and V in units of 2^-3f; the product of N and 1/V has one bit more or less than twice
        # the bits of each.
        units = numbers.vector_fraction - (2 * bits - 1) + span - size
        exponent = pipeline.register(lambda empty, short: units + empty - short, empty, short)
        pipeline.output(tag.exponent, exponent)
        for axis in range(3):
            pipeline.output(tag.normal[axis], pipeline.combine(lambda value: value[-bits:], shifted[axis]))
            sign = pipeline.input(item.normal[axis][-1])
            pipeline.output(tag.negative[axis], pipeline.combine(lambda a, b: a ^ b, sign, negative))
        pipeline.output(tag.dropped, dropped)
        pipeline.output(tag.slot, pipeline.input(item.slot))
        return pipeline

    def _make_factor(self):
        """m: in each phase one limb of N and of 1/V."""
        numbers, bits = self._config.numbers, self._bits
        pipeline, item, phase = self._phased(self._third, self.o)
        tag, factor = item.tag, self.o.payload.part
        half = OPERAND - 1

        def limb(value, bit):
            return pipeline.register(lambda phase: Mux(phase[bit], value[half:], value[:half]), phase)

        inverse = limb(item.inverse, 1)
        products = []
        for axis in range(3):
            part = self._product(pipeline, limb(tag.normal[axis], 0), inverse)
            low, *middle, high = (pipeline.before(part, PHASES - 1 - count) for count in range(PHASES))
            middle = pipeline.register(lambda a, b: a + b, *middle)
            outer = pipeline.register(lambda low, high: low + (high << 2 * half), low, high)
            products.append(pipeline.register(lambda a, b: (a << half) + b, middle, outer))
        longer = pipeline.combine(lambda *values: Cat(value[2 * bits - 1] for value in values).any(), *products)
        lost = bits + GUARD - 1
        dropped = pipeline.input(tag.dropped)
        most = (1 << numbers.mantissa_bits) - 1
        for axis, value in enumerate(products):
            def rounded(value, longer):
                near = Mux(longer, value >> lost, value >> lost - 1) + 1
                return (near >> 1)[:numbers.mantissa_bits + 1]

            near = pipeline.register(rounded, value, longer)
            negative = pipeline.input(tag.negative[axis])

            def finished(near, negative, dropped):
                size = Mux(near[-1], most, near)[:numbers.mantissa_bits]
                return Mux(dropped, 0, Mux(negative, -size, size))

            pipeline.output(factor.mantissa[axis], pipeline.register(finished, near, negative, dropped))
        pipeline.output(factor.exponent, pipeline.register(
            lambda exponent, longer, dropped: Mux(dropped, 0, exponent + lost + longer),
            pipeline.input(tag.exponent), longer, dropped))
        pipeline.output(factor.dropped, dropped)
        pipeline.output(self.o.payload.slot, pipeline.input(item.tag.slot))
        return pipeline


def _absolute(value):
    return Mux(value[-1], -value, value)[:len(value)]
