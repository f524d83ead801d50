"""The queue: a slot never has two sections, and each record that is collected is counted once, after its write."""

from amaranth.hdl import Assert, Assume, Cover, Signal

from golden.engine.config import PRESETS
from hw.control.completion_writer import CompletionWriter
from hw.control.frustum_slot import FrustumSlot
from tb.formal.bench import Bench, transfers
from tb.formal.declare import Control, declare
from tb.formal.source_fault import source_fault

CONFIG = PRESETS["tiny"].replace({"noc.columns": 1, "noc.rows": 1, "ctu.near_cell_bits": 5})


def one_section_a_slot(m, bench, dut):
    """A dispatch that sends one section for each want never meets a full slot, however late the words come."""
    owed, full, stored = Signal(3), Signal(), Signal()
    good = dut.i.valid & dut.i.payload.last & ~dut.i.payload.void
    m.d.sync += [owed.eq(owed + dut.requests - good), stored.eq(good)]
    with m.If(stored):
        m.d.sync += full.eq(1)
    with m.Elif(transfers(dut.o)):
        m.d.sync += full.eq(0)
    m.d.comb += [Assume(~dut.i.valid | (owed != 0)), Assume(~(dut.free & dut.o.valid)),
                 Assert(~(dut.i.valid & (stored | full)), "full"), Assert(owed <= 1, "owed"),
                 Assert(dut.o.valid == full, "valid"),
                 Cover(dut.o.valid & (owed == 0), "a section waits"),
                 Cover(dut.requests & (owed == 0) & dut.o_near.payload.bank, "the other bank")]


test_one_section_a_slot = declare(
    lambda kind=FrustumSlot: Bench(one_section_a_slot, kind(config=CONFIG)), cycles=10,
    controls={
        "it asks twice": Control("owed", kind=source_fault(FrustumSlot, "requested.eq(1)", "requested.eq(0)")),
        "a refused section fills it": Control("valid", kind=source_fault(
            FrustumSlot, "with m.If(~word.void):", "with m.If(~word.void | word.cluster):")),
        "it asks before its section is taken": Control("full", kind=source_fault(
            FrustumSlot, "self.free & ~self.o.valid & ~requested", "~requested | (self.o.valid & self.o.ready)")),
    })


def records_are_counted_once(m, bench, dut):
    """``completed`` is the number of records that memory has accepted, each of which was collected before; after a
    reset those without an answer are written again.
    """
    collected, outstanding, accepted = Signal(4), Signal(4), Signal(4)
    given = dut.o_collected.valid | transfers(dut.i_record)
    answers = dut.i_written.valid & ~dut.stops
    good = answers & ~dut.i_written.payload.error & ~dut.failed
    requested = Signal(4)
    m.d.sync += collected.eq(collected + given)
    with m.If(dut.stops):
        m.d.sync += [outstanding.eq(0), requested.eq(0)]
    with m.Else():
        m.d.sync += [outstanding.eq(outstanding + transfers(dut.o_data) - answers),
                     requested.eq(requested + transfers(dut.o_request) - transfers(dut.o_data))]
    with m.If(good):
        m.d.sync += accepted.eq(accepted + 1)
    again = Signal()
    with m.If(dut.stops & (outstanding != 0)):
        m.d.sync += again.eq(1)
    # One beat is a record here. Memory answers what it has received; a reset discards what comes in it.
    m.d.comb += [
        Assume(~answers | (outstanding != 0)), Assume(dut.completions == 0), Assume(dut.ring_bits == 31),
        Assert(dut.completed == accepted, "completed"), Assert(dut.completed <= collected, "collected"),
        Assert(~transfers(dut.o_data) | (requested != 0), "requested"),
        Assert(~(dut.empty & (dut.completed != collected)), "empty"),
        Assert(~dut.o_request.valid | (dut.o_request.payload.address[6:] < collected), "address"),
        Cover((dut.completed == 1) & again, "a record is written again"), Cover(dut.failed, "a write fails")]


test_records = declare(
    lambda kind=CompletionWriter: Bench(
        records_are_counted_once, kind(config=CONFIG.replace({"memory.data_bits": 512}))), cycles=16,
    engine="abc bmc3", controls={
        "a refused write counts": Control("completed", kind=source_fault(
            CompletionWriter, "& ~failing & ~self.stops):", "& ~self.stops):")),
        "a reset loses a record": Control("empty", kind=source_fault(
            CompletionWriter, "self.empty.eq(~busy & (collected == self.completed))",
            "self.empty.eq(~busy & (requested == sent))")),
    })
