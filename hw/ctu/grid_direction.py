"""Grid direction: of a grid ray's row and column in G."""

from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.data import ArrayLayout, StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from golden.engine.ctu.grid_rays import FRACTION
from hw.ctu.ctu_formats import CtuFormats
from hw.icu.ray_direction import direction
from hw.lib.fixed import round_shift, total
from hw.lib.pipeline import Pipeline
from hw.lib.skid_buffer import SkidBuffer

__all__ = ["GridDirection"]


class GridDirection(wiring.Component):
    """``to_global d``, rounded once, of the direction d that `RayDirection` makes of the same tables' entries.

    Parameters
    ----------
    config
        The configuration.
    tag
        Shape of the sideband.

    Members
    -------
    i : In, stream of ``tag``, ``column``, ``row``
        Entries of the shell's tables (`CtuFormats.grid_pair`).
    o : Out, stream of ``tag``, ``direction``
        The direction in G (`CtuFormats.grid_direction`).
    is_screen : In(1)
    to_global : In, 3 x 3 array
        The frustum's; constant while rays are in flight.

    Timing
    ------
    Latency: ``2 * product_registers + 6`` cycles. One ray per cycle; stalls while the ray at the end waits, and a
    register enables all others.

    Golden counterpart: `golden.engine.ctu.unit.global_directions` of a ray of `golden.engine.ctu.grid_rays.GridRays`.
    Source: Shen 1993, section 5.3.4.4.
    """

    def __init__(self, *, config: Config, tag):
        formats, numbers = CtuFormats(config), config.numbers
        pair = formats.grid_pair
        super().__init__({
            "i": In(stream.Signature(StructLayout({"tag": tag, "column": pair, "row": pair}))),
            "o": Out(stream.Signature(StructLayout({
                "tag": tag, "direction": ArrayLayout(formats.grid_direction, 3)}))),
            "is_screen": In(1), "to_global": In(ArrayLayout(formats.direction_vector, 3))})
        self._skid = SkidBuffer(self.o.payload.shape())
        self._pipeline = pipeline = Pipeline(self.i, self._skid.i, ready_next=self._skid.ready_next)
        given = self.i.payload
        local = direction(pipeline, pipeline.input(given.column), pipeline.input(given.row), self.is_screen,
                          fraction=FRACTION, registers=config.icu.product_registers)
        for axis in range(3):
            turned = total(pipeline, [
                pipeline.product(local[k], pipeline.constant(self.to_global[axis][k]),
                                 registers=config.icu.product_registers) for k in range(3)])
            pipeline.output(self._skid.i.payload.direction[axis], pipeline.register(
                lambda value: round_shift(value, numbers.direction_fraction), turned))
        pipeline.output(self._skid.i.payload.tag, pipeline.input(given.tag))
        self.latency = pipeline.latency + self._skid.latency

    def elaborate(self, platform):
        m = Module()
        self._pipeline.add_to(m)
        m.submodules.skid = self._skid
        wiring.connect(m, self._skid.o, wiring.flipped(self.o))
        return m
