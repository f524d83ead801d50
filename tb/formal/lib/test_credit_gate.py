from amaranth.hdl import Assert, Assume, Cover, Signal, Value

from hw.lib.credit_gate import CreditGate
from tb.formal.bench import Bench, transfers
from tb.formal.declare import Claim, Control, declare
from tb.formal.stream_rules import add_rules


def bounded(m, bench, dut, credits):
    """Never more items in flight than credits; while there are fewer, items pass as if there were no gate."""
    add_rules(m, dut.i, Assume)
    add_rules(m, dut.o, Assert)
    out = Signal(range(credits + 2))
    passes = transfers(dut.o)
    m.d.sync += out.eq(out + passes - dut.i_return.valid)
    with m.If(out == 0):
        m.d.comb += Assume(~dut.i_return.valid)
    free = out != credits
    m.d.comb += [
        Assert(out <= credits, "credits"), Assert(dut.level == out, "level"),
        Assert(passes == transfers(dut.i), "passes"), Assert(dut.o.valid == (dut.i.valid & free), "valid"),
        Assert(dut.i.ready == (dut.o.ready & free), "ready"),
        Assert(Value.cast(dut.o.payload) == Value.cast(dut.i.payload), "payload"),
        Cover((out == credits) & dut.i.valid & dut.i_return.valid, "the last credit comes back")]


test_credit_gate = declare(
    lambda credits=3, real=None: Bench(bounded, CreditGate(2, credits=real or credits), credits=credits),
    cycles=8, claims=[Claim(credits=credits, unbounded=True) for credits in (1, 2, 3, 4)],
    controls={
        "one credit too many": Control("credits", real=4),
        "offers without a credit": Control("valid", {"o__valid": lambda dut: dut.i.valid}),
        "another item": Control("payload", {"o__payload": lambda dut: dut.o.payload ^ dut.level[0]}),
    })
