import pytest
from amaranth.hdl import Assert, Cover, Module
from amaranth.lib import wiring

from hw.lib.join import Join
from tb.formal.connect_ports import connect_ports
from tb.formal.negative_control import NegativeControl
from tb.formal.prove import prove


class JoinTogether(wiring.Component):
    """Both inputs and the output move together, as soon as all three can, and the fields are the inputs' items."""

    def __init__(self, dut):
        self._dut = dut
        super().__init__(dut.signature)

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = self._dut
        connect_ports(m, self, self._dut)
        all_can = self.i_a.valid & self.i_b.valid & self.o.ready
        for port in (self.i_a, self.i_b, self.o):
            m.d.comb += Assert((port.valid & port.ready) == all_can)
        m.d.comb += Assert(self.o.valid == (self.i_a.valid & self.i_b.valid))
        with m.If(self.o.valid):
            m.d.comb += [Assert(self.o.payload.a == self.i_a.payload), Assert(self.o.payload.b == self.i_b.payload),
                         Cover(all_can)]
        return m


FAULTS = {
    "takes one without the other": {"i_a__ready": lambda dut: dut.o.ready},
    "gives what is not there": {"o__valid": lambda dut: dut.i_a.valid},
    "changes the fields": {"o__payload": lambda dut: dut.o.payload.as_value().rotate_left(2)},
}


def make():
    return Join({"a": 2, "b": 2})


def test_all_move_together():
    assert prove(JoinTogether(make()))
    assert prove(JoinTogether(make()), mode="cover", depth=3)


@pytest.mark.parametrize("fault", FAULTS)
def test_negative_control(fault):
    assert not prove(JoinTogether(NegativeControl(make(), FAULTS[fault])), mode="bmc", depth=3)
