"""Spherical coordinates: the angles of a vertex, or where a screen sees it."""

from amaranth.hdl import Const, Mux
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import IcuFormats
from hw.icu.icu_tables import GAIN_FRACTION, gain
from hw.lib.cordic import cordic
from hw.lib.fixed import magnitude, normalise, round_shift, serial_product, shift_right, with_sign
from hw.lib.pipeline import Pipeline

__all__ = ["SphericalCoordinates"]


class SphericalCoordinates(wiring.Component):
    """Hemisphere: azimuth and polar angle. Screen: x/z and y/z in units of 2^-``cordic_stages``.

    Two CORDICs in a chain. The azimuth is computed from (x, y), normalised; the polar angle of that
    pair's length and z, lengthened as much. What a screen does not see within 45 degrees of its axis has quotient 1 or
    -1.

    Parameters
    ----------
    config
        The configuration.
    interval
        Cycles from a vertex to the next one, at least.

    Members
    -------
    i : In, stream of ``slot``, ``index``, ``direction``, always ready
        V' of a vertex.
    o : Out, stream of ``slot``, ``index``, ``first``, ``second``, ``front``, always ready
        ``first``: azimuth or x/z. ``second``: polar angle, which may leave 0 to a half turn by its error, or y/z.
        ``front``: z is positive.
    is_screen : In(1)
        Stable while vertices are in flight.

    Timing
    ------
    Latency: ``2 * cordic_stages + bits(vertex_bits - 1) + (bits(vertex_bits - 1) + 1) // 2 + 11`` cycles, ``bits(n)``
    those of the number n. One vertex per ``interval`` cycles; nothing stalls.

    Golden counterpart: `golden.engine.icu.sbb.SphericalWindows.angles`, `golden.engine.icu.ipbb.ImagePlaneWindows`.
    Source: Shen 1993, section 5.3.5.
    """

    def __init__(self, *, config: Config, interval: int = 1):
        formats, icu, bits = IcuFormats(config), config.icu, config.numbers.vertex_bits
        key = {"slot": formats.slot, "index": 2}
        super().__init__({
            "i": In(stream.Signature(StructLayout({**key, "direction": formats.vertex_vector}), always_ready=True)),
            "o": Out(stream.Signature(StructLayout({**key, "first": formats.coordinate, "second": formats.coordinate,
                                                    "front": 1}), always_ready=True)),
            "is_screen": In(1)})
        self._pipeline = pipeline = Pipeline(self.i, self.o, interval=interval)
        given, made = self.i.payload, self.o.payload
        x, y, z = (pipeline.input(given.direction[axis]) for axis in range(3))
        # Sideband: a copy accompanies each vertex, so that its fan-out is low.
        is_screen = pipeline.input(self.is_screen)
        front = pipeline.combine(lambda z: (z > 0), z)
        # Both products of 1.65 (the gain) and sqrt 2 twice, and the sign.
        width = bits + icu.cordic_guard + 4

        # Magnitudes first: then one comparison finds the vertices that are more than 45 degrees off the screen's axis.
        sizes = [pipeline.register(magnitude, value) for value in (x, y, z)]
        signs = [pipeline.combine(lambda value: value[-1], value) for value in (x, y, z)]
        positive = pipeline.constant(Const(0, 1))

        def full_length(sizes, signs):
            """A pair with its larger magnitude at full length, and by how many bits it was shifted."""
            sizes, by = normalise(pipeline, bits, sizes)
            return *(pipeline.register(with_sign, *parts) for parts in zip(sizes, signs, strict=True)), by

        def within(axis):
            """Sizes of (z, across) of a screen's quotient, (1, 0) if not formed, and the value that replaces it."""
            outside = pipeline.combine(lambda across, z, behind: behind | (across >= z),
                                       sizes[axis], sizes[2], signs[2])
            pair = (pipeline.combine(lambda outside, z: Mux(outside, Const(1, len(z)), z), outside, sizes[2]),
                    pipeline.combine(lambda outside, across: Mux(outside, 0, across), outside, sizes[axis]))
            return *pair, outside, signs[axis]

        def chosen(screen, hemisphere):
            return pipeline.register(Mux, is_screen, screen, hemisphere)

        def guarded(value):
            return pipeline.combine(lambda value: (value << icu.cordic_guard).as_signed(), value)

        screen_x, screen_y = within(0), within(1)
        a, b, by = full_length([chosen(screen_x[axis], sizes[axis]) for axis in range(2)],
                               [chosen(positive, signs[0]), chosen(signs[0], signs[1])])
        first, length = cordic(pipeline, guarded(a), guarded(b), linear=is_screen, icu=icu, width=width)

        scale = round(gain(icu) * 2**GAIN_FRACTION)
        # A serial product fits between vertices that are far apart.
        lengthened = serial_product(pipeline, z, scale) if interval > 1 else pipeline.product(
            z, pipeline.constant(Const(scale)), registers=icu.product_registers)
        lengthened = pipeline.register(lambda value: round_shift(value, GAIN_FRACTION - icu.cordic_guard), lengthened)
        length = shift_right(pipeline, length, by, width)
        # The screen's second pair waits with short numbers until the first CORDIC is done.
        late = length.age - 1 - len(by.value)
        waiting = [pipeline.delay(value, late - value.age) for value in screen_y[:2]]
        c, d, _ = full_length(waiting, [positive, signs[1]])
        second, _ = cordic(pipeline, chosen(guarded(c), lengthened), chosen(guarded(d), length),
                           linear=is_screen, icu=icu, width=width)

        one, quarter = 1 << icu.cordic_stages, 1 << icu.angle_bits - 2

        def coordinate(is_screen, value, outside, negative, is_polar):
            """An angle, polar ones from minus a quarter turn on, or a quotient."""
            angle = value[:icu.angle_bits]
            if is_polar:
                wraps = angle >= 3 * quarter
                angle = Mux(wraps, angle.as_signed(), angle)
            quotient = Mux(outside, Mux(negative, -one, one), value[:icu.cordic_stages + 2].as_signed())
            return Mux(is_screen, quotient, angle)

        for name, value, screen, is_polar in (("first", first, screen_x, False), ("second", second, screen_y, True)):
            pipeline.output(made[name], pipeline.register(
                lambda *values, is_polar=is_polar: coordinate(*values, is_polar), is_screen, value, *screen[2:]))
        pipeline.output(made.front, front)
        for name in key:
            pipeline.output(made[name], pipeline.input(given[name]))
        self.latency = pipeline.latency

    def elaborate(self, platform):
        return self._pipeline.module()
