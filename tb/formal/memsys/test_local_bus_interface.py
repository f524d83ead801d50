from amaranth.hdl import Assert, Assume, Cover, Mux, Signal
from amaranth.lib import data

from golden.engine.config import PRESETS
from hw.lib.credit_gate import CreditGate
from hw.memsys.patches.local_bus_interface import LocalBusInterface
from hw.memsys.patches.path_formats import BEATS, PathFormats, RequestKind
from tb.formal.bench import Bench, transfers
from tb.formal.declare import Claim, Control, declare
from tb.formal.source_fault import with_parts
from tb.formal.stream_rules import add_rules

IDS = 2
CONFIG = PRESETS["tiny"].replace({
    "memsys.reply_ids": IDS, "memsys.bus_requests": 1, "memsys.scene_cells": 64, "memsys.own_cells": 16,
    "numbers.scene_bits": 12, "numbers.vector_fraction": 10, "icu.patch_bits": 8})


def nothing_lost(m, bench, dut):
    """No beat of any reply is lost, whoever stalls. Replies to outstanding requests come at any time, good ones and
    errors. An entry, or a vertex of a good reply, is offered exactly while one that has come has not been accepted. An
    error is reported once, with the number of its cell or patch: when its entry, or its last vertex, has left.
    """
    for given in (dut.i_cell, dut.i_patch):
        add_rules(m, given, Assume)
    for given in (dut.o_request, dut.o_listed, dut.o_vertex):
        add_rules(m, given, Assert)
    reply, request = dut.i_reply, dut.o_request
    error, formats = reply.payload.error, PathFormats(CONFIG)
    beat = data.View(formats.cell_beat, reply.payload.data[:formats.cell_beat.size])
    for kind, beats, out, lost, named, number_bits in (
            (RequestKind.CELL, IDS, dut.o_listed, dut.lost_cell, dut.cell, formats.cell_bits),
            (RequestKind.PATCH, BEATS, dut.o_vertex, dut.lost_patch, dut.patch, len(dut.patch))):
        requested, number, inside = (Signal(5, name=f"{what}_{kind.name}") for what in ("requested", "beat", "inside"))
        comes, ends, is_lost, reports, key = (Signal(bits, name=f"{what}_{kind.name}") for what, bits in (
            ("comes", 1), ("ends", 1), ("is_lost", 1), ("reports", 1), ("key", number_bits)))
        head = (number == 0) & (kind is RequestKind.PATCH)
        asks = transfers(request) & (request.payload.kind == kind)
        m.d.comb += [comes.eq(reply.valid & (reply.payload.kind == kind)), ends.eq(comes & reply.payload.last)]
        m.d.sync += [requested.eq(requested + asks - ends)]
        # One request is in flight: what is inside is of its reply.
        with m.If(asks):
            m.d.sync += key.eq(request.payload.key[:number_bits])
        with m.If(comes):
            m.d.comb += Assume(requested != 0)
            m.d.sync += [number.eq(Mux(reply.payload.last, 0, number + 1)), is_lost.eq(error)]
            if kind is RequestKind.PATCH:
                # The rules of `PathFormats.bus_reply`, which the interface claims of its neighbour.
                m.d.comb += [Assume(reply.payload.last == (number == beats - 1)), Assume(head | (error == is_lost))]
                with m.If(head):
                    m.d.comb += Assume(reply.payload.data[:number_bits] == key)
            else:
                m.d.comb += [Assume((number != beats - 1) | reply.payload.last),
                             Assume(~error | (reply.payload.last & ~beat.is_id & (number == 0)))]
        if kind is RequestKind.PATCH:
            # A lost vertex leaves in the cycle after it has come.
            m.d.sync += [inside.eq(inside + (comes & ~head & ~error) - transfers(out)), reports.eq(ends & error)]
            due = Signal()
            m.d.sync += due.eq(reports)
            m.d.comb += Assert(out.valid == (inside != 0), f"{kind.name} inside")
        else:
            m.d.sync += [inside.eq(inside + comes - transfers(out)), reports.eq(transfers(out) & is_lost)]
            due = reports
            m.d.comb += [Assert(out.valid == (inside != 0), f"{kind.name} inside"),
                         Cover(comes & beat.more & reply.payload.last, "another part follows")]
        m.d.comb += [Assert(lost == due, f"{kind.name} lost"), Assert(~lost | (named == key), f"{kind.name} number"),
                     Cover(comes & (inside == 1) & ~out.ready, f"{kind.name} comes while one waits")]
    m.d.comb += Cover(dut.lost_cell & dut.lost_patch, "both are lost")


class Generous(CreditGate):
    """Has one credit too many."""

    def __init__(self, shape, *, credits):
        super().__init__(shape, credits=credits + 1)


test_local_bus_interface = declare(
    lambda kind=LocalBusInterface: Bench(nothing_lost, kind(config=CONFIG)), cycles=14, engine="abc bmc3",
    covers_nightly=True, claims=[Claim(), Claim(cycles=30, nightly=True)],
    controls={
        "one credit too many": Control("CELL inside", kind=with_parts(LocalBusInterface, CreditGate=Generous)),
        "of both that are lost the cell's number": Control("PATCH number", {
            "patch": lambda dut: Mux(dut.lost_cell, dut.cell, dut.patch)})})
