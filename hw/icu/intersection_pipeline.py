"""Intersection pipeline: from a ray and a patch to the ray memory."""

from amaranth.hdl import Module, Signal, Value
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from golden.engine.config import Config
from hw.icu.icu_formats import IcuFormats
from hw.icu.inverse_distance import InverseDistance
from hw.icu.patch_slots import PatchSlots
from hw.icu.ray_direction import RayDirection
from hw.icu.screening import Screening
from hw.icu.uv_alignment import UvAlignment
from hw.icu.uv_subdivision import UvSubdivision
from hw.lib.connect_fields import connect_fields
from hw.lib.struct_stream import struct_stream

__all__ = ["IntersectionPipeline"]


class IntersectionPipeline(wiring.Component):
    """One ray per cycle: its direction, the patch's slot, screening and inverse distance, nearest update, (u, v).

    ::

        RayDirection - PatchSlots -+- Screening -+- UvAlignment - UvSubdivision - (u, v) of wins
                                   |             '----------.
                                   '- InverseDistance ---- update - won

    Rays that miss pass like all others. (u, v) are computed for every ray that is tested, and arrive after the result
    of the nearest update. With ``uv_bits`` 0 there are none, and ``o_payload`` is never valid.

    Parameters
    ----------
    config
        The configuration.

    Members
    -------
    i : In, stream of `IcuFormats.issued`, always ready
        Rays and ends of patches.
    i_table : In, stream of `IcuFormats.table_write`, always ready
        For `RayDirection`.
    i_planes, i_winding, i_factor, i_exponents, i_patch : In, streams of ``slot``, ``part``, always ready
        Parts for `PatchSlots`; ``i_exponents`` only where there are (u, v).
    o_update : Out, stream of ``ray``, ``inverse``, ``patch``, ``hit``, always ready
        To `RayMemory.i`.
    i_update : In, stream of ``ray``, ``inverse``, ``won``, always ready
        The reply, ``update_latency`` cycles later.
    o_payload : Out, stream of ``ray``, ``u``, ``v``, always ready
        Of rays that won.
    o_done : Out, stream of a patch id, always ready
        A patch, after its last ray has been written.
    free : Out(1)
        The slot that was allocated first has been read for the last time.
    is_screen : In(1)
        Stable while rays are in flight.
    i_ray : In, stream of ``ray``, ``x``, ``y``, always ready
        Slopes for `RayDirection`. Only with ``shadow_bits``.
    is_shadow : In(1)
        For `RayDirection`. Only with ``shadow_bits``.
    tested : Out(1)
        A ray leaves screening.
    inside : Out(1)
        A ray leaves screening that is inside its patch.

    Timing
    ------
    ``latency`` cycles from ``i`` to ``o_payload`` and ``o_done``. One ray per cycle; nothing stalls.

    Golden counterpart: `golden.engine.icu.intersection`. Source: Shen 1993, section 5.3.5.
    """

    def __init__(self, *, config: Config, update_latency: int):
        self._config, self._formats = config, IcuFormats(config)
        formats = self._formats

        ray = {"ray": formats.ray, "is_ray": 1, "last": 1}
        self._direction = RayDirection(config=config, tag=StructLayout({**ray, "slot": formats.slot}))
        self._shadow = config.icu.shadow_bits > 0
        super().__init__({
            "i": In(stream.Signature(formats.issued, always_ready=True)),
            **({name: self._direction.signature.members[name] for name in ("i_ray", "is_shadow")}
               if self._shadow else {}),
            "i_table": In(stream.Signature(formats.table_write, always_ready=True)),
            **{f"i_{name}": In(struct_stream({"slot": formats.slot, "part": field.shape}))
               for name, field in formats.slot_record},
            "o_update": Out(struct_stream({"ray": formats.ray, "inverse": formats.inverse, "patch": formats.patch,
                                           "hit": 1})),
            "i_update": In(struct_stream({"ray": formats.ray, "inverse": formats.inverse, "won": 1})),
            "o_payload": Out(struct_stream({"ray": formats.ray, "u": formats.uv, "v": formats.uv})),
            "o_done": Out(stream.Signature(formats.patch, always_ready=True)),
            "free": Out(1), "is_screen": In(1), "tested": Out(1), "inside": Out(1)})
        self._slots = PatchSlots(config=config, tag=StructLayout({**ray, "direction": formats.direction_vector}))
        exponents = {"exponents": formats.exponents} if config.icu.uv_bits else {}
        self._screening = Screening(config=config, tag=StructLayout({**ray, "patch": formats.patch, **exponents}))
        self._inverse = InverseDistance(config=config, tag=StructLayout({"ray": formats.ray, "patch": formats.patch}))
        self._inside_waits = self._inverse.latency - self._screening.latency
        # From screening to `o_done`.
        self._behind = self._inside_waits + update_latency
        if config.icu.uv_bits:
            self._alignment = UvAlignment(config=config, tag=StructLayout({**ray, "patch": formats.patch}))
            self._subdivision = UvSubdivision(config=config, tag=StructLayout({**ray, "patch": formats.patch}))
            self._behind = self._alignment.latency + self._subdivision.latency
        self._won_waits = self._behind - self._inside_waits - update_latency
        if min(self._inside_waits, self._won_waits) < 0:
            raise ValueError("Latencies must be such that inverse distances come after screening and (u, v) after the "
                             "nearest update")
        self.latency = self._direction.latency + self._slots.latency + self._screening.latency + self._behind

    def elaborate(self, platform):
        m = Module()
        m.submodules.direction, m.submodules.slots = direction, slots = self._direction, self._slots
        m.submodules.screening, m.submodules.inverse = screening, inverse = self._screening, self._inverse
        wiring.connect(m, wiring.flipped(self.i_table), direction.i_table)
        for name, _ in self._formats.slot_record:
            wiring.connect(m, wiring.flipped(getattr(self, f"i_{name}")), getattr(slots, f"i_{name}"))

        issued = self.i.payload
        connect_fields(m, direction.i, self.i, tags=[issued], column=issued.column, row=issued.row)
        m.d.comb += direction.is_screen.eq(self.is_screen)
        if self._shadow:
            wiring.connect(m, wiring.flipped(self.i_ray), direction.i_ray)
            m.d.comb += [direction.i.payload.ray.eq(issued.ray), direction.is_shadow.eq(self.is_shadow)]
        turned = direction.o.payload
        connect_fields(m, slots.i, direction.o, tags=[turned.tag], slot=turned.tag.slot)
        m.d.comb += slots.i.payload.tag.direction.eq(turned.direction)
        m.d.comb += self.free.eq(direction.o.valid & turned.tag.last)

        read, record = slots.o.payload.tag, slots.o.payload.record
        connect_fields(m, screening.i, slots.o, tags=[read, record], direction=read.direction,
                       planes=record.planes, winding=record.winding)
        connect_fields(m, inverse.i, slots.o, tags=[read, record], direction=read.direction,
                       mantissa=record.factor.mantissa, exponent=record.factor.exponent)

        screened = screening.o.payload
        m.d.comb += [self.tested.eq(screening.o.valid & screened.tag.is_ray),
                     self.inside.eq(self.tested & screened.inside)]
        near = inverse.o.payload
        update = self.o_update.payload
        m.d.comb += [self.o_update.valid.eq(inverse.o.valid), update.ray.eq(near.tag.ray),
                     update.patch.eq(near.tag.patch), update.inverse.eq(near.inverse),
                     update.hit.eq(_later(m, self.inside, self._inside_waits))]

        if self._config.icu.uv_bits:
            self._add_uv(m, screened)
        else:
            last = screening.o.valid & screened.tag.last
            m.d.comb += [self.o_done.valid.eq(_later(m, last, self._behind)),
                         self.o_done.payload.eq(_later(m, screened.tag.patch, self._behind))]
        return m

    def _add_uv(self, m, screened):
        m.submodules.alignment, m.submodules.subdivision = alignment, subdivision = self._alignment, self._subdivision
        connect_fields(m, alignment.i, self._screening.o, tags=[screened.tag], distances=screened.distances,
                       orientation=screened.orientation, exponents=screened.tag.exponents)
        connect_fields(m, subdivision.i, alignment.o, tags=[alignment.o.payload.tag],
                       distances=alignment.o.payload.distances)
        made = subdivision.o.payload
        won = _later(m, self.i_update.valid & self.i_update.payload.won, self._won_waits)
        m.d.comb += [self.o_payload.valid.eq(subdivision.o.valid & won), self.o_payload.payload.ray.eq(made.tag.ray),
                     self.o_payload.payload.u.eq(made.u), self.o_payload.payload.v.eq(made.v),
                     self.o_done.valid.eq(subdivision.o.valid & made.tag.last),
                     self.o_done.payload.eq(made.tag.patch)]


def _later(m, value, cycles):
    """The value ``cycles`` cycles later."""
    for _ in range(cycles):
        register = Signal.like(Value.cast(value), init=0)
        m.d.sync += register.eq(value)
        value = register
    return value
