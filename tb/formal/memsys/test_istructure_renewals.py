"""The I-structure with renewals: a location, and reads of it, while it is written and renewed in any order."""

from amaranth.hdl import Assert, Assume, Cover, Signal

from hw.memsys.patches.istructure import IStructure
from tb.formal.bench import Bench, transfers
from tb.formal.declare import Claim, Control, declare
from tb.formal.memsys.istructure_cycles import CLOSING, REFUSAL
from tb.formal.source_fault import source_fault
from tb.formal.stream_rules import add_rules

# Cycles from a write to the first answer of those that waited.
RELEASE = 8


def renewed_in_any_order(m, bench, dut, depth, deferred):
    """Any one location, any one read of it at a time, and a later read of it: their tags are 1 and 2, others 0.

    Asserts, by name:

    ``presence``
        A write is refused exactly if the location was written after its last renewal.
    ``once``
        The read is answered at most once; no read is answered that was not made.
    ``early``
        It is not answered before the location has had a datum since it was made.
    ``data``
        It is answered with a datum that the location had since it was made; if it waited, with the next one written.
    ``order``
        Reads of a location are answered in their order.
    ``late``
        It is answered within a bound while its location is present, or if it waited and then was written.
    ``ready``
        Writes and renewals are always accepted, except beside a start; a start begins within a bound.
    """
    location = bench.choose(m, range(depth), "location")
    for given in (dut.i_start, dut.i_read, dut.i_write, dut.i_renew):
        add_rules(m, given, Assume)
    read_request, wrote, answer = dut.i_read.payload, dut.i_write.payload, dut.o_read.payload
    starts, reads, writes, renews, gives = (transfers(port) for port in (
        dut.i_start, dut.i_read, dut.i_write, dut.i_renew, dut.o_read))
    m.d.comb += [Assume(one < depth) for one in (
        location, read_request.address, wrote.address, dut.i_renew.payload)]

    # The location. Renewals go before writes, one of both per cycle.
    present, data, refuses, begun = Signal(), Signal.like(wrote.data), Signal(REFUSAL), Signal()
    renewed, here = renews & (dut.i_renew.payload == location), writes & (wrote.address == location)
    written = here & ~present
    with m.If(written):
        m.d.sync += [present.eq(1), data.eq(wrote.data)]
    with m.If(renewed | starts):
        m.d.sync += present.eq(0)
    m.d.sync += [refuses.eq((refuses << 1) | (here & present)), begun.eq(begun | starts)]
    m.d.comb += Assert((dut.o_refused.valid & (dut.o_refused.payload == location)) == refuses[-1], "presence")
    m.d.comb += Assert(begun | ~(reads | writes | renews), "ready")
    with m.If(begun & ~dut.i_start.valid):
        m.d.comb += Assert(dut.i_renew.ready & (dut.i_write.ready == ~dut.i_renew.valid), "ready")

    # The read: which data it may be answered with.
    mine, later = reads & read_request.tag[0], reads & read_request.tag[1]
    out, second, may, waits = Signal(), Signal(), Signal(1 << len(wrote.data)), Signal()
    m.d.comb += [Assume(~mine | (~out & ~second)), Assume(~later | (out & ~second)), Assume(read_request.tag != 3),
                 Assume(~(mine | later) | (read_request.address == location))]
    inside = Signal(range(deferred + 12))
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
    m.d.comb += Assert((out | ~given) & (second | ~follows) & (inside <= deferred + 6), "once")
    m.d.comb += Assert(~given | may.any(), "early")
    m.d.comb += Assert(~given | ~may.any() | may.bit_select(answer.data, 1), "data")
    m.d.comb += Assert(~(follows & out), "order")

    released, not_full = waits & may.any(), dut.waiting != deferred
    for number, (name, counts, idles, bound) in enumerate((
            ("late", dut.o_read.ready, ~released, RELEASE + deferred),
            ("late", dut.o_read.ready & not_full, released | ~out | ~present | renewed, 2 * deferred + 11),
            ("ready", inside == 0, ~dut.i_start.valid | starts, depth + CLOSING))):
        cycles = Signal(range(bound + 2), name=f"cycles_{number}")
        with m.If(idles):
            m.d.sync += cycles.eq(0)
        with m.Elif(counts & (cycles != bound + 1)):
            m.d.sync += cycles.eq(cycles + 1)
        m.d.comb += Assert(cycles <= bound, name)

    # What occurs while the read is out.
    emptied, rewritten, waited, both = Signal(), Signal(), Signal(), Signal()
    m.d.sync += [emptied.eq(emptied | (renewed & present)), rewritten.eq(rewritten | (emptied & written)),
                 waited.eq(out & (waited | (waits & emptied & ~present))),
                 both.eq(second & (both | (out & (inside == dut.waiting))))]
    first_answered, second_answered = gives & answer.tag[0], gives & answer.tag[1]
    m.d.comb += [
        Cover(first_answered & waited & answer.data.all(), "a read waits for a renewed location"),
        Cover(refuses[-1] & rewritten, "a renewed location is written twice"),
        Cover(second_answered & both, "two reads wait for a location"),
        Cover(first_answered & waited & second & ~both, "a read comes while an earlier one is released")]


def make(depth=2, deferred=2, kind=IStructure):
    return Bench(renewed_in_any_order, kind(2, depth=depth, version_bits=1, deferred=deferred, tag=2, renews=True),
                 depth=depth, deferred=deferred)


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
FIRST = {breaks: fault for fault, (breaks, *_) in reversed(FAULTS.items())}

# A late answer needs more cycles, and is proved alone.
test_renewals = declare(
    make, cycles=19, engine="abc bmc3", covers_nightly=True,
    claims=[Claim(), Claim(only="late", cycles=26), Claim(only="order", cycles=22, nightly=True),
            Claim(depth=4, deferred=3, cycles=21, nightly=True)],
    controls={fault: Control(breaks, kind=source_fault(IStructure, right, wrong),
                             nightly=fault not in FIRST.values()) for fault, (breaks, right, wrong) in FAULTS.items()})
