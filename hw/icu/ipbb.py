"""IPBB: the window of pixels that holds a patch seen through a screen."""

from amaranth.hdl import Cat, Mux
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import IcuFormats
from hw.icu.icu_tables import DIAGONAL, EDGES, linear_error
from hw.lib.fixed import extreme, shift_left
from hw.lib.pipeline import Pipeline

__all__ = ["Ipbb"]


class Ipbb(wiring.Component):
    """Per axis the smallest and the largest quotient of the vertices in front of the eye, widened by CORDIC's error.

    Where an edge passes from the front to behind the eye the window reaches the border of the screen on the side to
    which the edge leaves, according to the edge plane's sign.

    Parameters
    ----------
    config
        The configuration.
    interval
        Cycles from a patch to the next one, at least.

    Members
    -------
    i : In, stream of `IcuFormats.seen`, always ready
        Quotients of a screen.
    o : Out, stream of ``slot``, ``window``, always ready
        `Formats.window`.
    frustum : In, `Formats.frustum`
        Stable while patches are in flight.

    Timing
    ------
    Latency: ``(bits(side_bits) + 1) // 2 + 10`` cycles, ``bits(n)`` those of the number n. A patch per ``interval``
    cycles; nothing stalls.

    Golden counterpart: `golden.engine.icu.ipbb.ImagePlaneWindows`.
    """

    def __init__(self, *, config: Config, interval: int = 1):
        formats, icu = IcuFormats(config), config.icu
        super().__init__({
            "i": In(stream.Signature(formats.seen, always_ready=True)),
            "o": Out(stream.Signature(StructLayout({"slot": formats.slot, "window": formats.window}),
                                      always_ready=True)),
            "frustum": In(formats.frustum)})
        self._pipeline = pipeline = Pipeline(self.i, self.o, interval=interval)
        seen, window = self.i.payload, self.o.payload.window
        one, error = 1 << icu.cordic_stages, linear_error(icu, config.numbers.vertex_bits)
        front = [seen.front[k] for k in range(4)]
        anything = pipeline.input(seen.signs)

        def crosses(edge):
            """Whether the edge passes the plane of the eye."""
            first, second = EDGES[edge]
            passes = front[first] ^ front[second]
            return passes & seen.winding.split if edge == DIAGONAL else passes

        def runs(component, negated, side):
            """Whether an edge that passes behind the eye runs off to the negative or positive side, or either."""
            found = []
            for edge in range(5):
                sign = seen.signs[edge][component]
                # From the end in front to the one behind.
                flipped = (sign != 0) & (sign[-1] ^ ~front[EDGES[edge][0]] ^ negated)
                kept = (sign != 0) & ~(sign[-1] ^ ~front[EDGES[edge][0]] ^ negated)
                found.append(crosses(edge) & ~(kept if side < 0 else flipped))
            return Cat(found).any()

        def border(vertices, component, negated, largest):
            """The window's border as a quotient."""
            outmost = -one if largest else one
            values = [pipeline.register(lambda _, k=k: Mux(front[k], vertices[k], outmost).as_signed(), anything)
                      for k in range(4)]
            inner = pipeline.register(lambda value: value + (error if largest else -error),
                                      extreme(pipeline, values, largest=largest))
            off = pipeline.register(lambda _: runs(component, negated, 1 if largest else -1), anything)
            return pipeline.register(lambda off, inner: Mux(off, -outmost, inner).as_signed(), off, inner)

        def index(value, bits, size, last):
            """First or last of the entries (2 i + 1 - size) / 2^bits that are inside; in a shadow frustum also those
            that are within half an entry's width.
            """
            value = shift_left(pipeline, value, pipeline.constant(bits), len(value.value) + icu.side_bits)
            beside = 1
            if icu.shadow_bits:
                beside = Mux(self.frustum.is_shadow, 0 if last else 2, 1)
            middle = ((size - beside) << icu.cordic_stages) + (0 if last else (one << 1) - 1)
            return pipeline.register(lambda value: ((value + middle) >> icu.cordic_stages + 1).as_signed(), value)

        size_bits = icu.side_bits.bit_length()
        some = [pipeline.input(seen.front.any() & Cat(*seen.winding.orientation).any())]
        borders = []
        for vertices, component, negated, name, bits in ((seen.first, 1, 0, "column", "column_bits"),
                                                         (seen.second, 0, 1, "row", "row_bits")):
            size = self.frustum[name + "s"]
            first, last = (index(border(vertices, component, negated, largest), self.frustum[bits][:size_bits], size,
                                 largest) for largest in (False, True))
            first = pipeline.register(lambda value: Mux(value < 0, 0, value), first)
            last = pipeline.register(lambda value, size=size: Mux(value >= size, size - 1, value), last)
            count = pipeline.register(lambda first, last: last - first + 1, first, last)
            some.append(pipeline.combine(lambda count: count > 0, count))
            borders += [(name + "_first", first), (name + "_count", count)]
        some = pipeline.register(lambda *conditions: Cat(conditions).all(), *some)
        for name, value in borders:
            pipeline.output(window[name], pipeline.register(lambda some, value: Mux(some, value, 0), some, value))
        pipeline.output(self.o.payload.slot, pipeline.input(seen.slot))
        self.latency = pipeline.latency

    def elaborate(self, platform):
        return self._pipeline.module()
