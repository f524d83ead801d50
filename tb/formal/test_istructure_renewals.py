"""The I-structure with renewals: a location, and reads of it, while it is written and renewed in any order."""

import pytest
from amaranth.hdl import Assert, Assume, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In

from hw.memsys.istructure import IStructure
from tb.formal.connect_ports import connect_ports
from tb.formal.prove import prove
from tb.formal.source_fault import source_fault
from tb.formal.stream_rules import add_rules
from tb.formal.test_istructure import CLOSING, REFUSAL

ENGINE, DEPTH = "abc bmc3", 19
# Cycles from a write to the first answer of those that waited.
RELEASE = 8
CASES = ("a read waits for a renewed location", "a renewed location is written twice", "two reads wait for a location",
         "a read comes while an earlier one is released")


class Renewed(wiring.Component):
    """Any one location, any one read of it at a time, and a later read of it: their tags are 1 and 2, others 0.

    Asserts, by name:

    ``presence``
        A write is refused exactly if the location was written after its last renewal.
    ``once``
        The read is answered at most once, and no read that was not made.
    ``early``
        It is not answered before the location has had a datum since it was made.
    ``data``
        It is answered with a datum that the location had since it was made; if it waited, with the next one written.
    ``order``
        Reads of a location are answered in their order.
    ``late``
        It is answered within a bound while its location is present, or if it waited and then was written.
    ``ready``
        Writes and renewals are always taken, but for a start; a start begins within a bound.

    Parameters
    ----------
    dut
        The component, with two bits of data and of tags.
    depth, deferred
        Its size.
    only
        The one assertion that is made, instead of all; or one of `CASES`, which is asserted not to occur.
    """

    def __init__(self, dut, *, depth, deferred, only=None):
        self._dut, self._depth, self._deferred, self._only = dut, depth, deferred, only
        super().__init__({**dict(dut.signature.members.items()), "location": In(range(depth))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = dut = self._dut
        location, chosen = Signal(range(self._depth)), Signal()
        m.d.sync += chosen.eq(1)
        with m.If(~chosen):
            m.d.sync += location.eq(self.location)
        connect_ports(m, self, dut)
        for given in (self.i_start, self.i_read, self.i_write, self.i_renew):
            add_rules(m, given, Assume)
        asked, wrote, answer = dut.i_read.payload, dut.i_write.payload, dut.o_read.payload
        starts, reads, writes, renews, gives = (port.valid & port.ready for port in (
            dut.i_start, dut.i_read, dut.i_write, dut.i_renew, dut.o_read))
        m.d.comb += [Assume(one < self._depth) for one in (
            self.location, asked.address, wrote.address, dut.i_renew.payload)]

        # The location. Renewals go before writes, one of both per cycle.
        present, data, refuses, begun = Signal(), Signal.like(wrote.data), Signal(REFUSAL), Signal()
        renewed, here = renews & (dut.i_renew.payload == location), writes & (wrote.address == location)
        written = here & ~present
        with m.If(written):
            m.d.sync += [present.eq(1), data.eq(wrote.data)]
        with m.If(renewed | starts):
            m.d.sync += present.eq(0)
        m.d.sync += [refuses.eq((refuses << 1) | (here & present)), begun.eq(begun | starts)]
        self._check(m, "presence", (dut.o_refused.valid & (dut.o_refused.payload == location)) == refuses[-1])
        self._check(m, "ready", begun | ~(reads | writes | renews))
        with m.If(begun & ~dut.i_start.valid):
            self._check(m, "ready", dut.i_renew.ready & (dut.i_write.ready == ~dut.i_renew.valid))

        # The read: which data it may be answered with.
        mine, later = reads & asked.tag[0], reads & asked.tag[1]
        out, second, may, waits = Signal(), Signal(), Signal(1 << len(wrote.data)), Signal()
        m.d.comb += [Assume(~mine | (~out & ~second)), Assume(~later | (out & ~second)), Assume(asked.tag != 3),
                     Assume(~(mine | later) | (asked.address == location))]
        inside = Signal(range(self._deferred + 12))
        m.d.sync += inside.eq(inside + reads - gives)
        with m.If(mine):
            m.d.sync += [out.eq(1), may.eq((present << data) | (written << wrote.data))]
        with m.Elif(out):
            with m.If(written & ~(waits & may.any())):
                m.d.sync += may.eq(may | (1 << wrote.data))
            # All reads that are inside wait, so this one does.
            with m.If((inside == dut.waiting) & ~may.any()):
                m.d.sync += waits.eq(1)
        given, follows = dut.o_read.valid & answer.tag[0], dut.o_read.valid & answer.tag[1]
        with m.If(gives & answer.tag[0]):
            m.d.sync += [out.eq(0), waits.eq(0), may.eq(0)]
        m.d.sync += second.eq((second | later) & ~(gives & answer.tag[1]))
        self._check(m, "once", (out | ~given) & (second | ~follows) & (inside <= self._deferred + 6))
        self._check(m, "early", ~given | may.any())
        self._check(m, "data", ~given | ~may.any() | may.bit_select(answer.data, 1))
        self._check(m, "order", ~(follows & out))

        released, room = waits & may.any(), dut.waiting != self._deferred
        for number, (name, counts, idles, bound) in enumerate((
                ("late", dut.o_read.ready, ~released, RELEASE + self._deferred),
                ("late", dut.o_read.ready & room, released | ~out | ~present | renewed, 2 * self._deferred + 11),
                ("ready", inside == 0, ~dut.i_start.valid | starts, self._depth + CLOSING))):
            cycles = Signal(range(bound + 2), name=f"cycles_{number}")
            with m.If(idles):
                m.d.sync += cycles.eq(0)
            with m.Elif(counts & (cycles != bound + 1)):
                m.d.sync += cycles.eq(cycles + 1)
            self._check(m, name, cycles <= bound)

        # What occurs while the read is out.
        emptied, rewritten, waited, both = Signal(), Signal(), Signal(), Signal()
        m.d.sync += [emptied.eq(emptied | (renewed & present)), rewritten.eq(rewritten | (emptied & written)),
                     waited.eq(out & (waited | (waits & emptied & ~present))),
                     both.eq(second & (both | (out & (inside == dut.waiting))))]
        first_answered, second_answered = gives & answer.tag[0], gives & answer.tag[1]
        for case, happens in zip(CASES, (
                first_answered & waited & answer.data.all(), refuses[-1] & rewritten, second_answered & both,
                first_answered & waited & second & ~both), strict=True):
            if self._only == case:
                m.d.comb += Assert(~happens)
        return m

    def _check(self, m, name, holds):
        if self._only in (None, name):
            m.d.comb += Assert(holds)


def make(depth=2, deferred=2, *, kind=IStructure, only=None):
    return Renewed(kind(2, depth=depth, version_bits=1, deferred=deferred, tag=2, renews=True), depth=depth,
                   deferred=deferred, only=only)


# By fault: the assertion that fails, and the component's text before and after.
FAULTS = {
    "a renewed location stays written": (
        "presence", 'add_memory("presence", 0, write.address, 0, written, renewed)',
        'add_memory("presence", 0, write.address, 0, written, 0)'),
    "a write in flight does not see a renewal": (
        "presence", "with m.If(renewed & self._meet(access, write)):",
        "with m.If(renewed & self._meet(access, write) & (access is not writes[2])):"),
    "a chain is released twice": (
        "once", "forgets.eq(store.i_release.valid)", "forgets.eq(0)"),
    "a read is answered while others wait": (
        "early", "present.eq(read.state.present | (meets & written))",
        "present.eq(read.state.present | (meets & written) | store.waiting[1])"),
    "a renewed location keeps its datum": (
        "data", 'add_memory("values", self._shape, write.address, write.carried, written, renewed)',
        'add_memory("values", self._shape, write.address, write.carried, written, 0)'),
    "a read in flight does not see a renewal": (
        "data", "with m.If(renewed & self._meet(access, write)):",
        "with m.If(renewed & self._meet(access, write) & (access is not reads[1])):"),
    "a read overtakes those that waited": (
        "order", "follows.eq(store.releases if self._renews else store.o.valid)", "follows.eq(store.o.valid)"),
    "a renewal forgets those that wait": (
        "late", "changed.known.eq(1), changed.present.eq(0)]",
        "changed.known.eq(1), changed.present.eq(0), changed.chain_known.eq(1), changed.chain.some.eq(0)]"),
    "a write is taken beside a renewal": (
        "ready", "accepts & ~self.i_renew.valid if self._renews else accepts", "accepts"),
}


# Of each assertion one in a commit's tests.
FIRST = {only: fault for fault, (only, *_) in reversed(FAULTS.items())}
# A late answer needs more cycles, and is proved alone.
LATE = 26


@pytest.mark.parametrize("fault", [
    pytest.param(fault, marks=[] if fault in FIRST.values() else pytest.mark.nightly) for fault in FAULTS])
def test_negative_control(fault):
    only, right, wrong = FAULTS[fault]
    control = make(kind=source_fault(IStructure, right, wrong), only=only)
    assert not prove(control, mode="bmc", depth=LATE if only == "late" else DEPTH, engine=ENGINE)


@pytest.mark.parametrize("case", CASES)
def test_reaches(case):
    assert not prove(make(only=case), mode="bmc", depth=DEPTH, engine=ENGINE)


def test_in_the_first_cycles():
    assert prove(make(), mode="bmc", depth=DEPTH, engine=ENGINE)


def test_answers_in_time():
    assert prove(make(only="late"), mode="bmc", depth=LATE, engine=ENGINE)


@pytest.mark.nightly
@pytest.mark.parametrize(("depth", "deferred", "cycles", "only"), [(2, 2, 22, "order"), (4, 3, 21, None)])
def test_longer_and_larger(depth, deferred, cycles, only):
    assert prove(make(depth, deferred, only=only), mode="bmc", depth=cycles, engine=ENGINE)
