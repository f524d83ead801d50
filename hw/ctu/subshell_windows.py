"""Subshell windows: the windows of the subshells' patches, found anew for each frustum."""

from amaranth.hdl import Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.ctu.ctu_formats import CtuFormats
from hw.icu.edge_planes import EdgePlanes
from hw.icu.g2r_transform import G2rTransform
from hw.icu.icu_formats import IcuFormats
from hw.icu.ipbb import Ipbb
from hw.icu.sbb import Sbb
from hw.icu.spherical_coordinates import SphericalCoordinates
from hw.icu.vertex_direction import VertexDirection
from hw.icu.vertex_gather import VertexGather
from hw.lib.queue import Queue
from hw.lib.validate import check_integer

__all__ = ["VERTICES", "SubshellWindows"]

# Subshells between their patch's request and their window: as many as keep the blocks at their rate.
SUBSHELLS = 4
# Vertices that are requested and not accepted yet, at most. Whoever answers has a buffer for all of them: an answer
# that waits would block answers to other clusters, which could deadlock.
VERTICES = 4 * SUBSHELLS


class SubshellWindows(wiring.Component):
    """From patches to windows, by the blocks of the intersection unit's patch setup with few multipliers.

    ::

        G2rTransform - VertexDirection -+- VertexGather - EdgePlanes ---------.
                                        '- SphericalCoordinates - VertexGather - Sbb or Ipbb

    A window without rays is discarded: the patch is seen edge-on or outside, or it is the rays' own source. A patch
    whose plane passes through the origin is not distinguished from others, which patch setup does with the plane
    itself: such a subshell requests grid rays in vain.

    Parameters
    ----------
    config
        The configuration.
    interval
        Cycles from a vertex to the next one, at least 15. In 16 cycles three multipliers make all products, two of
        them those of `G2rTransform`; for these one is enough in 18. From 18 on each CORDIC is one stage that goes
        round, below it is two.

    Members
    -------
    i : In, stream of `CtuFormats.subshell`
        Subshells.
    o_patch : Out, stream of patches; i_vertex : In, stream of `Formats.patch_vertex`
        A requested patch, and four vertices of each in the order of the requests.
    i_table : In, stream of `IcuFormats.table_write`
        Table entries, of which SLACK is used. Always ready; not during a frustum.
    o : Out, stream of `CtuFormats.subshell_window`
        Windows, in the order of the subshells.
    frustum : In, `Formats.frustum`
        Constant during a frustum.

    Timing
    ------
    ``latency`` cycles from a patch's first vertex to its window in a hemisphere, if the others follow at once, with
    `Ipbb` in place of `Sbb` of a screen. A subshell every ``4 * interval`` cycles; stalls with ``o`` and ``o_patch``
    and while vertices are missing. 4 subshells are in flight.

    Raises
    ------
    TypeError, ValueError
        ``interval`` is no integer, or too small for the blocks' order.

    Golden counterpart: `golden.engine.icu.patch_setup.PatchSetup`, of which only the window is made. Source: Shen 1993,
    section 5.3.4.2.
    """

    def __init__(self, *, config: Config, interval: int = 16):
        check_integer("Interval", interval, minimum=15)
        formats, icu = CtuFormats(config), IcuFormats(config)
        self._formats = formats
        self._interval = interval
        super().__init__({
            "i": In(stream.Signature(formats.subshell)), "o_patch": Out(stream.Signature(formats.patch)),
            "i_vertex": In(stream.Signature(formats.patch_vertex)),
            "i_table": In(stream.Signature(icu.table_write, always_ready=True)),
            "o": Out(stream.Signature(formats.subshell_window)), "frustum": In(formats.frustum)})
        self._transform, self._direction, self._coordinates, self._planes, self._sbb = (
            block(config=config, interval=interval)
            for block in (G2rTransform, VertexDirection, SphericalCoordinates, EdgePlanes, Sbb))
        self._ipbb = Ipbb(config=config, interval=4 * interval)
        self._vertices = VertexGather(config=config, shape=icu.vertex_vector)
        self._seen = VertexGather(config=config, shape=StructLayout({
            "first": icu.coordinate, "second": icu.coordinate, "front": 1}))
        planes = self._vertices.latency + self._planes.latency
        if self._coordinates.latency + self._seen.latency >= planes:
            raise ValueError(f"Interval must be so long that coordinates come before planes, not {interval!r}")
        self.latency = (3 * interval + self._transform.latency + self._direction.latency + planes + self._sbb.latency
                        + 1)

    def elaborate(self, platform):
        m = Module()
        formats = self._formats
        m.submodules.transform, m.submodules.direction = transform, direction = self._transform, self._direction
        m.submodules.coordinates, m.submodules.planes = coordinates, planes = self._coordinates, self._planes
        m.submodules.vertices, m.submodules.seen = vertices, seen = self._vertices, self._seen
        m.submodules.sbb, m.submodules.ipbb = sbb, ipbb = self._sbb, self._ipbb
        screen = self.frustum.is_screen
        for block in (transform, sbb, ipbb):
            m.d.comb += block.frustum.eq(self.frustum)
        m.d.comb += [coordinates.is_screen.eq(screen), sbb.i_table.valid.eq(self.i_table.valid),
                     sbb.i_table.payload.eq(self.i_table.payload)]

        # Subshells in flight, their windows, and whether their patches are the rays' own.
        m.submodules.waiting = waiting = Queue(StructLayout({"shell": formats.shell, "last": 1}), depth=SUBSHELLS)
        m.submodules.windows = windows = Queue(formats.window, depth=SUBSHELLS)
        m.submodules.own = own = Queue(1, depth=SUBSHELLS)
        given, last = self.i.payload, self.i.payload.last
        m.d.comb += [
            self.o_patch.valid.eq(self.i.valid & ~last & waiting.i.ready), self.o_patch.payload.eq(given.patch),
            waiting.i.valid.eq(self.i.valid & (last | self.o_patch.ready)), waiting.i.payload.shell.eq(given.shell),
            waiting.i.payload.last.eq(last), self.i.ready.eq(waiting.i.ready & (last | self.o_patch.ready))]

        # A vertex every so many cycles.
        since, index = Signal(range(self._interval), init=self._interval - 1), Signal(2)
        vertex, source = self.i_vertex.payload, self.frustum.source
        enters = self.i_vertex.valid & self.i_vertex.ready
        m.d.comb += [
            self.i_vertex.ready.eq(since == self._interval - 1), transform.i.valid.eq(enters),
            transform.i.payload.index.eq(index), transform.i.payload.vertex.eq(vertex.vertex),
            own.i.valid.eq(enters & (index == 3)), own.i.payload.eq((vertex.surface == source) & (source >= 0))]
        with m.If(enters):
            m.d.sync += [since.eq(0), index.eq(index + 1)]
        with m.Elif(since != self._interval - 1):
            m.d.sync += since.eq(since + 1)

        turned, short, spherical = (block.o.payload for block in (transform, direction, coordinates))
        m.d.comb += [
            direction.i.valid.eq(transform.o.valid), direction.i.payload.index.eq(turned.index),
            direction.i.payload.vertex.eq(turned.vertex),
            coordinates.i.valid.eq(direction.o.valid), coordinates.i.payload.index.eq(short.index),
            coordinates.i.payload.direction.eq(short.direction),
            vertices.i.valid.eq(direction.o.valid), vertices.i.payload.index.eq(short.index),
            vertices.i.payload.item.eq(short.direction),
            planes.i.valid.eq(vertices.o.valid), planes.i.payload.directions.eq(vertices.o.payload.items),
            seen.i.valid.eq(coordinates.o.valid), seen.i.payload.index.eq(spherical.index),
            *(seen.i.payload.item[name].eq(spherical[name]) for name in ("first", "second", "front"))]
        # A patch's coordinates come before its planes, and those of the next one after them.
        coordinate = Signal.like(seen.o.payload, reset_less=True)
        with m.If(seen.o.valid):
            m.d.sync += coordinate.eq(seen.o.payload)
        for block, mine in ((sbb, ~screen), (ipbb, screen)):
            whole = block.i.payload
            m.d.comb += [
                block.i.valid.eq(planes.o.valid & mine), whole.winding.eq(planes.o.payload.winding),
                whole.signs.eq(planes.o.payload.signs),
                *(target.eq(coordinate.items[k][name]) for k in range(4) for name, target in (
                    ("first", whole.first[k]), ("second", whole.second[k]), ("front", whole.front[k])))]
        m.d.comb += [windows.i.valid.eq(Mux(screen, ipbb.o.valid, sbb.o.valid)),
                     windows.i.payload.eq(Mux(screen, ipbb.o.payload.window, sbb.o.payload.window))]

        window, head, leaves = windows.o.payload, waiting.o.payload, Signal()
        passes_over = ~head.last & (own.o.payload | (window.row_count == 0))
        m.d.comb += [
            self.o.payload.window.eq(window), self.o.payload.shell.eq(head.shell), self.o.payload.last.eq(head.last),
            self.o.valid.eq(waiting.o.valid & (head.last | (windows.o.valid & ~passes_over))),
            leaves.eq((self.o.valid & self.o.ready) | (waiting.o.valid & windows.o.valid & passes_over)),
            waiting.o.ready.eq(leaves), windows.o.ready.eq(leaves & ~head.last), own.o.ready.eq(leaves & ~head.last)]
        return m
