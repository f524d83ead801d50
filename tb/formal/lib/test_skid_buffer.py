from amaranth.hdl import Assert, Cover, Signal, Value
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
    _add_flow(m, dut, mark, dut.o.valid)


def order_with_bypass(m, bench, dut):
    """An item that finds none waiting passes unchanged in its own cycle, or waits; it is ready unless one waits."""
    mark = bench.free(1, "mark")
    passes = transfers(dut.i) & transfers(dut.o)
    inside = add_fifo_order(m, push=transfers(dut.i) & ~passes, pushed=dut.i.payload, pop=transfers(dut.o) & ~passes,
                            popped=dut.o.payload, capacity=1, mark=mark)
    m.d.comb += [Assert(dut.o.valid == ((inside != 0) | dut.i.valid), "valid"),
                 Assert(dut.i.ready == (inside != 1), "ready")]
    with m.If(passes):
        m.d.comb += [Assert(Value.cast(dut.o.payload) == Value.cast(dut.i.payload), "order"), Cover(mark, "passes")]
    _add_flow(m, dut, mark, dut.o.valid | ~dut.i.valid)


def _add_flow(m, dut, mark, offers):
    """What it says of the next cycle holds there, and without stalls there are none."""
    promised = Signal(init=1)
    m.d.sync += promised.eq(dut.ready_next)
    m.d.comb += Assert(dut.i.ready == promised, "next")
    flows = Signal(range(4))
    with m.If(dut.o.ready & dut.i.valid):
        m.d.sync += flows.eq(flows + (flows != 3))
    with m.Else():
        m.d.sync += flows.eq(0)
    with m.If(flows == 3):
        m.d.comb += [Assert(dut.i.ready, "flow"), Assert(offers, "flow"), Cover(mark, "flows")]


SHAPE = StructLayout({"a": 1, "b": 2})

test_skid_buffer = declare(
    lambda: Bench(order_and_count, SkidBuffer(SHAPE)), cycles=10,
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

test_bypass = declare(
    lambda: Bench(order_with_bypass, SkidBuffer(SHAPE, bypass=True)), cycles=10,
    claims=[Claim(unbounded=True)],
    controls={
        "is ready only when its sink is": Control("ready", {"i__ready": lambda dut: dut.i.ready & dut.o.ready}),
        "promises too much": Control("next", {"ready_next": lambda dut: dut.ready_next | ~dut.o.ready}),
        "passes another item": Control("order", {"o__payload": lambda dut: Value.cast(dut.o.payload) ^ dut.i.ready}),
        "offers only what waits": Control("valid", {"o__valid": lambda dut: dut.o.valid & ~dut.i.ready}),
    })
