import pytest
from amaranth.hdl import Assert, Cover, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In

from hw.lib.skid_buffer import SkidBuffer
from tb.formal.connect_ports import connect_ports
from tb.formal.fifo_order import add_fifo_order
from tb.formal.negative_control import NegativeControl
from tb.formal.prove import prove

SHAPE = StructLayout({"a": 1, "b": 2})


class SkidBufferOrder(wiring.Component):
    """Order and count; it is ready unless two items are inside, and both directions are registered."""

    def __init__(self, dut):
        self._dut = dut
        super().__init__({**dict(dut.signature.members.items()), "mark": In(1)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = dut = self._dut
        connect_ports(m, self, dut)
        inside = add_fifo_order(
            m, push=dut.i.valid & dut.i.ready, pushed=dut.i.payload, pop=dut.o.valid & dut.o.ready,
            popped=dut.o.payload, capacity=2, mark=self.mark)
        m.d.comb += [Assert(dut.o.valid == (inside != 0)), Assert(dut.i.ready == (inside != 2))]
        # Without stalls there are none.
        flows = Signal(range(4))
        with m.If(self.o.ready & self.i.valid):
            m.d.sync += flows.eq(flows + (flows != 3))
        with m.Else():
            m.d.sync += flows.eq(0)
        with m.If(flows == 3):
            m.d.comb += [Assert(dut.i.ready), Assert(dut.o.valid), Cover(self.mark)]
        return m


FAULTS = {
    "is ready when full": {"i__ready": lambda dut: 1},
    "is ready only when its sink is": {"i__ready": lambda dut: dut.i.ready & dut.o.ready},
    "delivers an item twice": {"o__valid": lambda dut: dut.o.valid | ~dut.i.ready | dut.i.valid},
}


def test_order_and_count():
    assert prove(SkidBufferOrder(SkidBuffer(SHAPE)))


def test_reaches_full_and_flows():
    assert prove(SkidBufferOrder(SkidBuffer(SHAPE)), mode="cover", depth=10)


@pytest.mark.parametrize("fault", FAULTS)
def test_negative_control(fault):
    assert not prove(SkidBufferOrder(NegativeControl(SkidBuffer(SHAPE), FAULTS[fault])), mode="bmc", depth=10)
