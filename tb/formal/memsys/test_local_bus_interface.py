from amaranth.hdl import Assert, Assume, Cover, Signal
from amaranth.lib import data

from golden.config import PRESETS
from hw.lib.credit_gate import CreditGate
from hw.memsys.local_bus_interface import LocalBusInterface
from hw.memsys.path_formats import BEATS, PathFormats, RequestKind
from tb.formal.bench import Bench, transfers
from tb.formal.declare import Claim, Control, declare
from tb.formal.source_fault import with_parts
from tb.formal.stream_rules import add_rules

IDS = 2
CONFIG = PRESETS["tiny"].replace({
    "memsys.reply_ids": IDS, "memsys.bus_requests": 1, "memsys.scene_cells": 64, "memsys.own_cells": 16,
    "numbers.scene_bits": 12, "numbers.vector_fraction": 10, "icu.patch_bits": 8})


def nothing_lost(m, bench, dut):
    """No beat of any reply is lost, whoever stalls. Replies to outstanding requests come at any time. An entry, or a
    vertex, is offered exactly while one that has come has not been accepted.
    """
    for given in (dut.i_cell, dut.i_patch):
        add_rules(m, given, Assume)
    for given in (dut.o_request, dut.o_listed, dut.o_vertex):
        add_rules(m, given, Assert)
    reply, request = dut.i_reply, dut.o_request
    beat = data.View(PathFormats(CONFIG).cell_beat, reply.payload.data[:PathFormats(CONFIG).cell_beat.size])
    # A cell has few parts, as a list has an end.
    parts = Signal(2)
    for kind, beats, out in ((RequestKind.CELL, IDS, dut.o_listed), (RequestKind.PATCH, BEATS, dut.o_vertex)):
        requested, number, inside = (Signal(5, name=f"{what}_{kind.name}") for what in ("requested", "beat", "inside"))
        comes, ends = Signal(name=f"comes_{kind.name}"), Signal(name=f"ends_{kind.name}")
        head = (number == 0) & (kind is RequestKind.PATCH)
        m.d.comb += [comes.eq(reply.valid & (reply.payload.kind == kind)), ends.eq(comes & reply.payload.last)]
        m.d.sync += [
            requested.eq(requested + (transfers(request) & (request.payload.kind == kind)) - ends),
            inside.eq(inside + (comes & ~head) - transfers(out))]
        with m.If(comes):
            m.d.comb += [Assume(requested != 0), Assume(~reply.payload.error)]
            if kind is RequestKind.PATCH:
                m.d.comb += Assume(reply.payload.last == (number == beats - 1))
            else:
                with m.If(number == beats - 1):
                    m.d.comb += Assume(reply.payload.last)
                with m.If(beat.more & reply.payload.last):
                    m.d.sync += parts.eq(parts + 1)
                    m.d.comb += Assume(parts != 3)
            m.d.sync += number.eq(number + 1)
            with m.If(reply.payload.last):
                m.d.sync += number.eq(0)
        m.d.comb += [Assert(out.valid == (inside != 0), f"{kind.name} inside"),
                     Cover(comes & (inside == 1) & ~out.ready, f"{kind.name} comes while one waits")]
    m.d.comb += Cover(transfers(request) & (parts == 1), "requests the next part of a cell")


class Generous(CreditGate):
    """Has one credit too many."""

    def __init__(self, shape, *, credits):
        super().__init__(shape, credits=credits + 1)


test_local_bus_interface = declare(
    lambda kind=LocalBusInterface: Bench(nothing_lost, kind(config=CONFIG)), cycles=14, engine="abc bmc3",
    covers_nightly=True, claims=[Claim(slow=True), Claim(cycles=30, nightly=True)],
    controls={"one credit too many": Control("CELL inside", kind=with_parts(LocalBusInterface, CreditGate=Generous))})
