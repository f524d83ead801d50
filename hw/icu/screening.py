"""Screening: is a ray inside the edges of a patch? Exact, and so watertight."""

from amaranth.hdl import Cat, Mux
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import IcuFormats
from hw.lib.fixed import split_limbs, total
from hw.lib.pipeline import OPERAND, Pipeline

__all__ = ["Screening"]



class Screening(wiring.Component):
    """Six distances ``n_ij . d``, and whether none has the sign opposite to the orientation, zero counting as inside.

    A split patch is tested as two triangles; the first one has priority. Each component of a plane is two balanced
    limbs.

    Parameters
    ----------
    config
        The configuration.
    tag
        Shape of the sideband data.

    Members
    -------
    i : In, stream of ``tag``, ``direction``, ``planes``, ``winding``, always ready
        A ray, and `IcuFormats.planes` and `IcuFormats.winding` of a patch.
    o : Out, stream of ``tag``, ``distances``, ``inside``, ``orientation``, always ready
        The distances, whether the ray is inside, and the orientation for which it is.

    Timing
    ------
    Latency: ``product_registers + 6`` cycles. One ray per cycle; nothing stalls.

    Golden counterpart: `golden.engine.icu.screening.edge_distances`, `golden.engine.icu.screening.inside`. Source: Shen
    1993, section 5.3.5.
    """

    def __init__(self, *, config: Config, tag):
        formats = IcuFormats(config)
        super().__init__({
            "i": In(stream.Signature(StructLayout({
                "tag": tag, "direction": formats.direction_vector, "planes": formats.planes,
                "winding": formats.winding}),
                always_ready=True)),
            "o": Out(stream.Signature(StructLayout({
                "tag": tag, "distances": ArrayLayout(formats.edge_distance, 6), "inside": 1,
                "orientation": formats.orientation}), always_ready=True))})
        self._pipeline = pipeline = Pipeline(self.i, self.o)
        given, made = self.i.payload, self.o.payload
        direction = [pipeline.delay(pipeline.input(given.direction[axis]), 1) for axis in range(3)]
        distances = []

        def halves(value):
            """A plane is so far from the end of its format that the high limb has no bit more than are left for it."""
            return tuple(limb[:OPERAND].as_signed() for limb in split_limbs(value, OPERAND))

        for edge in range(6):
            limbs = [pipeline.register(halves, pipeline.input(given.planes[edge][axis])) for axis in range(3)]
            high, low = (total(pipeline, [pipeline.product(limb[k], direction[axis],
                                                           registers=config.icu.product_registers)
                                          for axis, limb in enumerate(limbs)]) for k in range(2))
            distances.append(pipeline.register(lambda high, low: (high << OPERAND) + low, high, low))
        signs = [pipeline.register(lambda value: Cat(value.any(), value[-1]).as_signed(), value) for value in distances]
        winding = pipeline.input(given.winding)

        def held(winding, *signs):
            """Whether each orientation held, that of the whole patch or of the two triangles."""
            def agree(which, *edges):
                turn = winding.orientation[which]
                return (turn != 0) & Cat(~((sign != 0) & (sign[-1] ^ turn[-1])) for sign in edges).all()

            s01, s12, s23, s30, s02, _ = signs
            # The diagonal bounds the first triangle from the other side.
            back = Cat(s02.any(), s02.any() & ~s02[-1]).as_signed()
            whole, one, two = agree(0, s01, s12, s23, s30), agree(0, s01, s12, back), agree(1, s02, s23, s30)
            return Cat(Mux(winding.split, one | two, whole), winding.split & ~one)

        held = pipeline.register(held, winding, *signs)
        for edge, value in enumerate(distances):
            pipeline.output(made.distances[edge], value)
        pipeline.output(made.inside, pipeline.combine(lambda held: held[0], held))
        pipeline.output(made.orientation, pipeline.combine(
            lambda held, winding: Mux(held[1], winding.orientation[1], winding.orientation[0]).as_signed(),
            held, winding))
        pipeline.output(made.tag, pipeline.input(given.tag))
        self.latency = pipeline.latency

    def elaborate(self, platform):
        return self._pipeline.module()
