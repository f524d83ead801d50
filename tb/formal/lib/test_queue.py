from amaranth.hdl import Assert
from amaranth.lib.data import StructLayout

from hw.lib.queue import Queue
from tb.formal.bench import Bench, transfers
from tb.formal.declare import Claim, Control, declare
from tb.formal.fifo_order import add_fifo_order

SHAPE = StructLayout({"a": 1, "b": 2})


def order_and_count(m, bench, dut, depth):
    """Order and count; it is ready unless full, and valid unless empty."""
    inside = add_fifo_order(m, push=transfers(dut.i), pushed=dut.i.payload, pop=transfers(dut.o), popped=dut.o.payload,
                            capacity=depth, mark=bench.free(1, "mark"))
    m.d.comb += [Assert(dut.level == inside, "level"), Assert(dut.o.valid == (inside != 0), "valid"),
                 Assert(dut.i.ready == (inside != depth), "ready")]


test_queue = declare(
    lambda depth=3, real=None: Bench(order_and_count, Queue(SHAPE, depth=real or depth), depth=depth),
    cycles=14, claims=[Claim(depth=depth, unbounded=True) for depth in (1, 2, 3, 4, 5)],
    controls={
        "is ready when full": Control("ready", {"i__ready": lambda dut: 1}),
        "delivers an item twice": Control(
            "order", {"o__valid": lambda dut: dut.o.valid | dut.i.valid}, nightly=True),
        "delivers the wrong item": Control(
            "order", {"o__payload": lambda dut: dut.o.payload.as_value() ^ (dut.level == 3)}),
        "counts wrongly": Control("level", {"level": lambda dut: dut.level + (dut.o.ready & dut.i.valid)}),
        "another depth": Control("ready", real=4, nightly=True),
    })
