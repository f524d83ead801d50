from amaranth.hdl import Assert, Assume, Cover, Signal

from hw.memsys.patches.work_count import WorkCount
from tb.formal.bench import Bench
from tb.formal.declare import Claim, Control, declare


def exact_count(m, bench, dut, most):
    """``level`` is the number of items that came less those that left. ``empty``: all had left a cycle ago."""
    # Totals modulo 64: their difference is exact, because at most ``most`` items are inside.
    came, left, late = Signal(6), Signal(6), Signal.like(dut.leaves)
    m.d.sync += [came.eq(came + sum(dut.enters)), late.eq(dut.leaves), left.eq(left + sum(late))]
    inside, after = Signal(6), Signal(8)
    m.d.comb += [inside.eq(came - left), after.eq(inside + sum(dut.enters) - sum(late)),
                 Assume(sum(dut.leaves) + sum(late) <= inside), Assume(after <= most),
                 Assert(dut.level == inside, "level"), Assert(dut.empty == (came == left), "empty"),
                 Cover((inside == most) & dut.leaves.all(), "the last entry")]


test_work_count = declare(
    lambda enters=2, leaves=3, most=7: Bench(
        exact_count, WorkCount(enters=enters, leaves=leaves, most=most), most=most), cycles=10,
    claims=[Claim(unbounded=True), Claim(enters=1, leaves=1, most=1, unbounded=True, nightly=True),
                       Claim(enters=1, leaves=4, most=9, unbounded=True, nightly=True)],
    controls={
        "one that is early": Control("empty", {"empty": lambda dut: (dut.level == 0) | (
            (dut.level == 1) & dut.leaves[0])}),
        "one that counts one input": Control("level", {"level": lambda dut: dut.level - (dut.level == 3)}),
    })
