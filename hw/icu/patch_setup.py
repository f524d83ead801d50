"""Patch setup: all that the intersection needs of a patch, once per frustum."""

from amaranth.hdl import Cat, Module, Mux, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.edge_planes import EdgePlanes
from hw.icu.g2r_transform import G2rTransform
from hw.icu.icu_formats import PHASES, IcuFormats
from hw.icu.inverse_distance_bound import InverseDistanceBound
from hw.icu.ipbb import Ipbb
from hw.icu.patch_queue import PatchQueue
from hw.icu.plane_factor import PlaneFactor
from hw.icu.sbb import Sbb
from hw.icu.section_clip import SectionClip
from hw.icu.spherical_coordinates import SphericalCoordinates
from hw.icu.vertex_direction import VertexDirection
from hw.icu.vertex_gather import VertexGather
from hw.lib.checks import claim
from hw.lib.connect_fields import connect_fields
from hw.lib.queue import Queue

__all__ = ["PatchSetup"]


class PatchSetup(wiring.Component):
    """From four vertices to a window and a threshold, and to the parts of the patch's slot record.

    ::

        PatchQueue - G2rTransform - VertexDirection -+- VertexGather - EdgePlanes -----------------.
                                                     +- VertexGather - PlaneFactor ------------.   |
                                                     '- SphericalCoordinates - VertexGather - Sbb or Ipbb
                                                                                   |        |
                                                          InverseDistanceBound ----'   SectionClip

    Nothing between the first queue and the last one stalls, because a patch enters only with a slot. Where branches
    join, the earlier one waits in a queue, which holds all patches that arrive meanwhile. A patch that cannot be hit
    (the rays' source, a plane through the origin, seen edge-on) has an empty window.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `Formats.patch_vertex`
        The four vertices of a patch follow each other.
    i_table : In, stream of `IcuFormats.table_write`, always ready
        For `Sbb` and `InverseDistanceBound`.
    o_planes, o_winding, o_factor, o_exponents, o_patch : Out, streams of ``slot``, ``part``, always ready
        Parts for `PatchSlots`; ``o_exponents`` only where there are (u, v).
    o : Out, stream of `IcuFormats.patch_window`
        Windows, in the order of the patches.
    free : In(1)
        See `PatchQueue`.
    frustum : In, `Formats.frustum`
        Stable while patches are in flight.

    Timing
    ------
    ``latency`` cycles from the fourth vertex to ``o``. One vertex per cycle, a patch every four cycles; stalls while
    all slots are taken.

    Golden counterpart: `golden.engine.icu.patch_setup.PatchSetup`, `golden.engine.icu.section_clip.section_clip`,
    `golden.engine.icu.settle_code.settle_threshold`. Source: Shen 1993, section 5.3.5.
    """

    def __init__(self, *, config: Config):
        self._config, self._formats = config, IcuFormats(config)
        formats = self._formats

        def part(shape):
            return Out(stream.Signature(StructLayout({"slot": formats.slot, "part": shape}), always_ready=True))

        super().__init__({
            "i": In(stream.Signature(formats.patch_vertex)),
            "i_table": In(stream.Signature(formats.table_write, always_ready=True)),
            **{f"o_{name}": part(field.shape) for name, field in formats.slot_record},
            "o": Out(stream.Signature(formats.patch_window)),
            "free": In(1), "frustum": In(formats.frustum)})
        self._queue, self._transform = PatchQueue(config=config), G2rTransform(config=config)
        self._direction, self._coordinates = VertexDirection(config=config), SphericalCoordinates(config=config)
        # Two, because what they hold is needed in distant places.
        self._directions = VertexGather(config=config, shape=formats.vertex_vector)
        self._vertices = VertexGather(config=config, shape=StructLayout({
            "vertex": formats.vector_vector, "exponent": formats.vertex_exponent}))
        self._seen = VertexGather(config=config, shape=StructLayout({
            "first": formats.coordinate, "second": formats.coordinate, "front": 1}))
        self._planes, self._factor = EdgePlanes(config=config), PlaneFactor(config=config)
        self._sbb, self._ipbb, self._clip = Sbb(config=config), Ipbb(config=config), SectionClip(config=config)
        self._bound = InverseDistanceBound(config=config)
        before = self._queue.latency + self._transform.latency + self._direction.latency
        planes = before + self._directions.latency + self._planes.latency
        seen = before + self._coordinates.latency + self._seen.latency
        corners = seen + self._ipbb.latency
        clipped = [seen + block.latency + self._clip.latency - self._bound.latency for block in (self._sbb, self._ipbb)]
        divided = before + self._vertices.latency + self._factor.latency
        # The plane factor comes after the windows, through a register at least: its sinks are far from each other.
        factor = max(divided, corners, *clipped) + 1
        self._registers = factor - divided
        # Cycles for which a patch waits in the queue of each name, at most.
        self._waits = {"known": seen - planes, "corners": factor - corners, "clipped": factor - min(clipped)}
        self.latency = factor + self._bound.latency + 3

    def elaborate(self, platform):
        m = Module()
        formats, slots = self._formats, self._config.icu.slots
        m.submodules.queue, m.submodules.transform = queue, transform = self._queue, self._transform
        m.submodules.direction, m.submodules.coordinates = direction, coordinates = self._direction, self._coordinates
        m.submodules.directions, m.submodules.vertices = directions, vertices = self._directions, self._vertices
        m.submodules.seen = seen = self._seen
        m.submodules.planes, m.submodules.factor = planes, factor = self._planes, self._factor
        m.submodules.sbb, m.submodules.ipbb, m.submodules.clip = sbb, ipbb, clip = self._sbb, self._ipbb, self._clip
        m.submodules.bound = bound = self._bound
        frustum, screen = self._add_frustum(m)
        for block in (sbb, bound):
            m.d.comb += [block.i_table.valid.eq(self.i_table.valid), block.i_table.payload.eq(self.i_table.payload)]

        wiring.connect(m, wiring.flipped(self.i), queue.i)
        m.d.comb += queue.free.eq(self.free)
        entered = queue.o.payload
        connect_fields(m, transform.i, queue.o, slot=entered.slot, index=entered.index, vertex=entered.item.vertex)
        connect_fields(m, self.o_patch, queue.o, slot=entered.slot, part=entered.item.patch)
        turned = transform.o.payload
        connect_fields(m, direction.i, transform.o, slot=turned.slot, index=turned.index, vertex=turned.vertex)
        seen_from = direction.o.payload
        connect_fields(m, coordinates.i, direction.o, slot=seen_from.slot, index=seen_from.index,
                       direction=seen_from.direction)
        vertex = vertices.i.payload.item
        connect_fields(m, directions.i, direction.o, slot=seen_from.slot, index=seen_from.index,
                       item=seen_from.direction)
        connect_fields(m, vertices.i, direction.o, slot=seen_from.slot, index=seen_from.index)
        m.d.comb += [vertex[name].eq(seen_from[name]) for name in ("vertex", "exponent")]
        spherical, coordinate = coordinates.o.payload, seen.i.payload.item
        connect_fields(m, seen.i, coordinates.o, slot=spherical.slot, index=spherical.index)
        m.d.comb += [coordinate[name].eq(spherical[name]) for name in ("first", "second", "front")]

        connect_fields(m, planes.i, directions.o, slot=directions.o.payload.slot,
                       directions=directions.o.payload.items)
        patch = vertices.o.payload
        connect_fields(m, factor.i, vertices.o, slot=patch.slot)
        m.d.comb += [factor.i.payload.vertices[k].eq(patch.items[k].vertex) for k in range(4)]
        if self._config.icu.uv_bits:
            connect_fields(m, self.o_exponents, vertices.o, slot=patch.slot)
            m.d.comb += [self.o_exponents.payload.part[k].eq(patch.items[k].exponent) for k in range(4)]
        connect_fields(m, self.o_planes, planes.o_planes, slot=planes.o_planes.payload.slot,
                       part=planes.o_planes.payload.part)
        connect_fields(m, self.o_winding, planes.o, slot=planes.o.payload.slot, part=planes.o.payload.winding)
        given = factor.o.valid, factor.o.payload
        for _ in range(self._registers):
            found, made = Signal(), Signal.like(factor.o.payload, reset_less=True)
            m.d.sync += [found.eq(given[0]), made.eq(given[1])]
            given = found, made
        m.d.comb += [self.o_factor.valid.eq(found), self.o_factor.payload.slot.eq(made.slot),
                     self.o_factor.payload.part.eq(made.part)]

        # Patches that cannot be hit, by slot.
        own, dropped = self._add_own(m, frustum.source), Signal(slots)
        with m.If(found):
            m.d.sync += dropped.bit_select(made.slot, 1).eq(made.part.dropped)

        def wait(name, shape, valid, payload, ready):
            """A queue between branches with the same order of patches."""
            m.submodules[name] = between = Queue(shape, depth=self._waits[name] // PHASES + 1)
            claim(m, ~between.i.valid | between.i.ready, f"a patch has an entry of {name}")
            claim(m, ~between.o.ready | between.o.valid, f"both branches of {name} have the patch")
            m.d.comb += [between.i.valid.eq(valid), between.i.payload.eq(payload), between.o.ready.eq(ready)]
            return between.o.payload

        signs = StructLayout({"winding": formats.winding, "signs": formats.signs})
        known = wait("known", signs, planes.o.valid, Cat(planes.o.payload.winding, planes.o.payload.signs),
                     seen.o.valid)
        for block, mine in ((sbb, ~screen), (ipbb, screen)):
            given = block.i.payload
            m.d.comb += [block.i.valid.eq(seen.o.valid & mine), given.slot.eq(seen.o.payload.slot),
                         given.winding.eq(known.winding), given.signs.eq(known.signs)]
            m.d.comb += [target.eq(seen.o.payload.items[k][name]) for k in range(4)
                         for name, target in (("first", given.first[k]), ("second", given.second[k]),
                                              ("front", given.front[k]))]
        m.d.comb += [clip.i.valid.eq(Mux(screen, ipbb.o.valid, sbb.o.valid)),
                     clip.i.payload.eq(Mux(screen, ipbb.o.payload, sbb.o.payload))]
        corners = wait("corners", formats.window, ipbb.o.valid, ipbb.o.payload.window, found & screen)
        m.d.comb += [bound.i.valid.eq(found), bound.i.payload.slot.eq(made.slot), bound.i.payload.factor.eq(made.part),
                     bound.i.payload.window.eq(corners)]
        clipped = wait("clipped", formats.section_window, clip.o.valid, clip.o.payload.window, bound.o.valid)

        m.submodules.ready = ready = Queue(formats.patch_window, depth=slots)
        wiring.connect(m, ready.o, wiring.flipped(self.o))
        # A register before and one behind the lookup of the slot's bits, which are placed far from bound and queue.
        (early, is_early), (window, is_known) = ((Signal(formats.patch_window, reset_less=True), Signal())
                                                 for _ in range(2))
        is_unseen = Signal(2, reset_less=True)
        m.d.sync += [
            is_early.eq(bound.o.valid), early.slot.eq(bound.o.payload.slot),
            early.threshold.eq(bound.o.payload.threshold), early.window.eq(clipped),
            is_known.eq(is_early), window.eq(early),
            is_unseen.eq(Cat(own.bit_select(early.slot, 1), dropped.bit_select(early.slot, 1)))]
        m.d.comb += [ready.i.valid.eq(is_known), ready.i.payload.eq(window)]
        claim(m, ~ready.i.valid | ready.i.ready, "a window has an entry")
        with m.If(is_unseen.any()):
            m.d.comb += ready.i.payload.window.eq(0)
        return m

    def _add_own(self, m, source):
        """By slot, whether a patch lies on the surface on which the rays start."""
        own, enters, entered = Signal(self._config.icu.slots), Signal(), self._queue.o.payload
        # One comparison of all bits would be a critical path: halves are compared here, and combined a cycle later.
        surface, half = entered.item.surface, len(entered.item.surface) // 2
        seen_own, seen_slot = Signal(3, reset_less=True), Signal.like(entered.slot, reset_less=True)
        m.d.sync += [enters.eq(self._queue.o.valid), seen_slot.eq(entered.slot),
                     seen_own.eq(Cat(surface[:half] == source[:half], surface[half:] == source[half:], source >= 0))]
        with m.If(enters):
            m.d.sync += own.bit_select(seen_slot, 1).eq(seen_own.all())
        return own

    def _add_frustum(self, m):
        """Connects the frustum to all blocks: it, and whether it is a screen where windows are."""
        # A register for the routing delay: the first vertex of a frustum arrives later.
        frustum = Signal(self._formats.frustum, reset_less=True)
        m.d.sync += frustum.eq(self.frustum)
        for block in (self._transform, self._sbb, self._ipbb, self._clip, self._bound):
            m.d.comb += block.frustum.eq(frustum)
        # A high-fanout bit with distant sinks: each register takes it from the one before.
        early, screen, late = (Signal(name=f"is_screen_{name}") for name in ("coordinates", "window", "bound"))
        m.d.sync += [early.eq(frustum.is_screen), screen.eq(early), late.eq(screen)]
        m.d.comb += [self._coordinates.is_screen.eq(early), self._clip.frustum.is_screen.eq(screen),
                     self._bound.frustum.is_screen.eq(late)]
        return frustum, screen
