"""The interface of the bus never asks for what it has no room for: no beat of any reply is lost, whoever waits."""

import pytest
from amaranth.hdl import Assert, Assume, Module, Signal
from amaranth.lib import data, wiring

from golden.config import PRESETS
from hw.lib.credit_gate import CreditGate
from hw.memsys import local_bus_interface as module
from hw.memsys.local_bus_interface import LocalBusInterface
from hw.memsys.path_formats import BEATS, PathFormats, RequestKind
from tb.formal.connect_ports import connect_ports
from tb.formal.prove import prove
from tb.formal.stream_rules import add_rules

IDS = 2
CONFIG = PRESETS["tiny"].replace({
    "memsys.reply_ids": IDS, "memsys.bus_requests": 1, "memsys.scene_cells": 64, "memsys.own_cells": 16,
    "numbers.scene_bits": 12, "numbers.vector_fraction": 10, "icu.patch_bits": 8})


class NothingLost(wiring.Component):
    """Replies come for what has been asked, at any time. An entry, or a vertex, is offered exactly while one that has
    come has not been taken.
    """

    def __init__(self, dut):
        self._dut = dut
        super().__init__(dut.signature)

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = dut = self._dut
        connect_ports(m, self, dut)
        for given in (self.i_cell, self.i_patch):
            add_rules(m, given, Assume)
        for given in (self.o_request, self.o_listed, self.o_vertex):
            add_rules(m, given, Assert)
        reply, request = dut.i_reply, dut.o_request
        beat = data.View(PathFormats(CONFIG).cell_beat, reply.payload.data[:PathFormats(CONFIG).cell_beat.size])
        # A cell has few parts, as a list has an end.
        parts = Signal(2)
        for kind, beats, out in ((RequestKind.CELL, IDS, dut.o_listed), (RequestKind.PATCH, BEATS, dut.o_vertex)):
            asked, number, inside = (Signal(5, name=f"{what}_{kind.name}") for what in ("asked", "beat", "inside"))
            comes, ends = Signal(name=f"comes_{kind.name}"), Signal(name=f"ends_{kind.name}")
            head = (number == 0) & (kind is RequestKind.PATCH)
            m.d.comb += [comes.eq(reply.valid & (reply.payload.kind == kind)), ends.eq(comes & reply.payload.last)]
            m.d.sync += [
                asked.eq(asked + (request.valid & request.ready & (request.payload.kind == kind)) - ends),
                inside.eq(inside + (comes & ~head) - (out.valid & out.ready))]
            with m.If(comes):
                m.d.comb += [Assume(asked != 0), Assume(~reply.payload.error)]
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
            m.d.comb += [Assert(out.valid == (inside != 0))]
        return m


def check(depth):
    return prove(NothingLost(LocalBusInterface(config=CONFIG)), mode="bmc", depth=depth, engine="abc bmc3")


def test_no_beat_is_lost():
    assert check(14)


@pytest.mark.nightly
def test_no_beat_is_lost_for_longer():
    assert check(30)


class Generous(CreditGate):
    """Has one credit too many."""

    def __init__(self, shape, *, credits):
        super().__init__(shape, credits=credits + 1)


def test_one_credit_too_many(monkeypatch):
    monkeypatch.setattr(module, "CreditGate", Generous)
    assert not check(14)
