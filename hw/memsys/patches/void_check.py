"""Void check: finds patches that their cluster does not hold."""

from amaranth.hdl import Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.formats import VERTICES, Formats

__all__ = ["VoidCheck"]


class VoidCheck(wiring.Component):
    """Finds the patches whose four vertices are all 0: replies of a cluster that does not hold the patch.

    No patch of a scene is void: `golden.engine.scene.g_coordinates.GCoordinates` has a margin, so no coordinate is 0,
    and `golden.engine.memory_map.check.check_image` refuses such a patch.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    vertex : In(Formats.scene_vector)
        Vertices, the four of a patch one after the other.
    moves : In(1)
        There is one in this cycle.
    index : Out(2)
        Its number in its patch.
    void : Out(1)
        It is the last one of a void patch.

    Timing
    ------
    Latency: ``0`` cycles.
    """

    latency = 0

    def __init__(self, *, config: Config):
        super().__init__({"vertex": In(Formats(config).scene_vector), "moves": In(1), "index": Out(range(VERTICES)),
                          "void": Out(1)})

    def elaborate(self, platform):
        m = Module()
        # Of the vertices of the patch before this one.
        were_zero, is_zero = Signal(), Signal()
        m.d.comb += [is_zero.eq(~self.vertex.as_value().any()),
                     self.void.eq(self.moves & were_zero & is_zero & (self.index == VERTICES - 1))]
        with m.If(self.moves):
            m.d.sync += [self.index.eq(self.index + 1), were_zero.eq((were_zero | (self.index == 0)) & is_zero)]
        return m
