from amaranth.hdl import Assert, Cover, Signal
from amaranth.lib.data import StructLayout

from hw.lib.skid_buffer import SkidBuffer
from tb.formal.bench import Bench, transfers
from tb.formal.declare import Claim, Control, declare
from tb.formal.fifo_order import add_fifo_order


def order_and_count(m, bench, dut):
    """Order and count; it is ready unless two items are inside, and both directions are registered; when it is ready is
    known a cycle before."""
    mark = bench.free(1, "mark")
    inside = add_fifo_order(m, push=transfers(dut.i), pushed=dut.i.payload, pop=transfers(dut.o), popped=dut.o.payload,
                            capacity=2, mark=mark)
    m.d.comb += [Assert(dut.o.valid == (inside != 0), "valid"), Assert(dut.i.ready == (inside != 2), "ready")]
    # What it says of the next cycle holds there.
    promised = Signal(init=1)
    m.d.sync += promised.eq(dut.ready_next)
    m.d.comb += Assert(dut.i.ready == promised, "next")
    # Without stalls there are none.
    flows = Signal(range(4))
    with m.If(dut.o.ready & dut.i.valid):
        m.d.sync += flows.eq(flows + (flows != 3))
    with m.Else():
        m.d.sync += flows.eq(0)
    with m.If(flows == 3):
        m.d.comb += [Assert(dut.i.ready, "flow"), Assert(dut.o.valid, "flow"), Cover(mark, "flows")]


test_skid_buffer = declare(
    lambda: Bench(order_and_count, SkidBuffer(StructLayout({"a": 1, "b": 2}))), cycles=10,
    claims=[Claim(unbounded=True)],
    controls={
        "is ready when full": Control("ready", {"i__ready": lambda dut: 1}),
        "is ready only when its sink is": Control(
            "ready", {"i__ready": lambda dut: dut.i.ready & dut.o.ready}, nightly=True),
        "promises too much": Control("next", {"ready_next": lambda dut: dut.ready_next | ~dut.o.ready}),
        "stalls every other cycle": Control("flow", {"o__valid": lambda dut: dut.o.valid & ~dut.o.payload.a}),
        "delivers an item twice": Control(
            "order", {"o__valid": lambda dut: dut.o.valid | ~dut.i.ready | dut.i.valid}),
    })
