import pytest
from amaranth.hdl import Assert, Module
from amaranth.lib import wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In

from hw.lib.queue import Queue
from tb.formal.around import connect_ports
from tb.formal.follow import follow
from tb.formal.prove import prove
from tb.formal.twin import Twin

SHAPE = StructLayout({"a": 1, "b": 2})


class QueueOrder(wiring.Component):
    """Order and count; it takes while there is room, and shows whatever there is."""

    def __init__(self, dut, depth):
        self._dut, self._depth = dut, depth
        super().__init__({**dict(dut.signature.members.items()), "marks": In(1)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = dut = self._dut
        connect_ports(m, self, dut)
        inside = follow(m, dut.i.valid & dut.i.ready, dut.i.payload, dut.o.valid & dut.o.ready, dut.o.payload,
                        room=self._depth, marks=self.marks)
        m.d.comb += [Assert(dut.level == inside), Assert(dut.o.valid == (inside != 0)),
                     Assert(dut.i.ready == (inside != self._depth))]
        return m


FAULTS = {
    "takes what it has no room for": {"i__ready": lambda dut: 1},
    "gives an item twice": {"o__valid": lambda dut: dut.o.valid | dut.i.valid},
    "gives the wrong item": {"o__payload": lambda dut: dut.o.payload.as_value() ^ (dut.level == 3)},
    "counts wrongly": {"level": lambda dut: dut.level + (dut.o.ready & dut.i.valid)},
}


@pytest.mark.parametrize("depth", [1, 2, 3, 4, 5])
def test_order_and_count(depth):
    assert prove(QueueOrder(Queue(SHAPE, depth=depth), depth))


def test_reaches_full():
    assert prove(QueueOrder(Queue(SHAPE, depth=5), 5), mode="cover", depth=14)


@pytest.mark.parametrize("fault", FAULTS)
def test_broken_twin(fault):
    proof = prove(QueueOrder(Twin(Queue(SHAPE, depth=3), FAULTS[fault]), 3), mode="bmc", depth=12)
    assert not proof
    assert proof.trace


def test_another_depth_is_noticed():
    assert not prove(QueueOrder(Queue(SHAPE, depth=4), 3), mode="bmc", depth=8)
