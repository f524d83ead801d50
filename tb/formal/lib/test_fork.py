from amaranth.hdl import Assert, Assume, Cover, Signal, Value
from amaranth.lib.data import StructLayout

from hw.lib.fork import Fork
from tb.formal.bench import Bench, transfers
from tb.formal.declare import Claim, Control, declare
from tb.formal.stream_rules import add_rules

COUNT = 3


def each_output_once(m, bench, dut):
    """While an item waits each output takes it at most once; when it is taken every output has it."""
    add_rules(m, dut.i, Assume)
    has, takes = Signal(COUNT), Signal(COUNT)
    for k, output in enumerate(dut.o):
        m.d.comb += [takes[k].eq(transfers(output)), Assert(~output.valid | dut.i.valid, "offers"),
                     Assert(~output.valid | (Value.cast(output.payload) == Value.cast(dut.i.payload)), "payload")]
        # No output waits for another one.
        with m.If(dut.i.valid & ~has[k]):
            m.d.comb += Assert(output.valid, "waits")
    m.d.comb += Assert(~(takes & has).any(), "once")
    with m.If(transfers(dut.i)):
        m.d.sync += has.eq(0)
        m.d.comb += [Assert((takes | has).all(), "all"), Cover((has == 0b010) & (takes == 0b101), "different cycles")]
    with m.Else():
        m.d.sync += has.eq(has | takes)
    with m.If(dut.i.valid & (takes | has).all()):
        m.d.comb += Assert(dut.i.ready, "ready")


test_fork = declare(
    lambda: Bench(each_output_once, Fork(StructLayout({"a": 1, "b": 2}), count=COUNT)), cycles=6,
    claims=[Claim(unbounded=True)],
    controls={
        "gives an item twice": Control("once", {"o__1__valid": lambda dut: dut.i.valid}),
        "forgets an output": Control("all", {"i__ready": lambda dut: dut.o[0].ready & dut.o[1].ready}),
        "waits for another output": Control("waits", {"o__2__valid": lambda dut: dut.o[2].valid & dut.o[0].ready}),
        "gives the wrong item": Control("payload", {"o__2__payload": lambda dut: 0}),
    })
