import pytest
from amaranth.hdl import Assert, Module
from amaranth.lib import wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In

from hw.lib.queue import Queue
from tb.formal.connect_ports import connect_ports
from tb.formal.fifo_order import add_fifo_order
from tb.formal.negative_control import NegativeControl
from tb.formal.prove import prove

SHAPE = StructLayout({"a": 1, "b": 2})


class QueueOrder(wiring.Component):
    """Order and count; it is ready unless full, and valid unless empty."""

    def __init__(self, dut, depth):
        self._dut, self._depth = dut, depth
        super().__init__({**dict(dut.signature.members.items()), "mark": In(1)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = dut = self._dut
        connect_ports(m, self, dut)
        inside = add_fifo_order(
            m, push=dut.i.valid & dut.i.ready, pushed=dut.i.payload, pop=dut.o.valid & dut.o.ready,
            popped=dut.o.payload, capacity=self._depth, mark=self.mark)
        m.d.comb += [Assert(dut.level == inside), Assert(dut.o.valid == (inside != 0)),
                     Assert(dut.i.ready == (inside != self._depth))]
        return m


FAULTS = {
    "is ready when full": {"i__ready": lambda dut: 1},
    "delivers an item twice": {"o__valid": lambda dut: dut.o.valid | dut.i.valid},
    "delivers the wrong item": {"o__payload": lambda dut: dut.o.payload.as_value() ^ (dut.level == 3)},
    "counts wrongly": {"level": lambda dut: dut.level + (dut.o.ready & dut.i.valid)},
}


@pytest.mark.parametrize("depth", [1, 2, 3, 4, 5])
def test_order_and_count(depth):
    assert prove(QueueOrder(Queue(SHAPE, depth=depth), depth))


def test_reaches_full():
    assert prove(QueueOrder(Queue(SHAPE, depth=5), 5), mode="cover", depth=14)


@pytest.mark.parametrize("fault", FAULTS)
def test_negative_control(fault):
    proof = prove(QueueOrder(NegativeControl(Queue(SHAPE, depth=3), FAULTS[fault]), 3), mode="bmc", depth=12)
    assert not proof
    assert proof.trace


def test_another_depth_is_noticed():
    assert not prove(QueueOrder(Queue(SHAPE, depth=4), 3), mode="bmc", depth=8)
