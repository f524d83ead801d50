import pytest
from amaranth.hdl import Assert, Assume, Cover, Module, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.data import StructLayout

from hw.lib.fork import Fork
from tb.formal.connect_ports import connect_ports
from tb.formal.negative_control import NegativeControl
from tb.formal.prove import prove
from tb.formal.stream_rules import add_rules

SHAPE = StructLayout({"a": 1, "b": 2})
COUNT = 3


class ForkOnce(wiring.Component):
    """While an item waits each output takes it at most once; when it is taken every output has it."""

    def __init__(self, dut):
        self._dut = dut
        super().__init__(dut.signature)

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = dut = self._dut
        connect_ports(m, self, dut)
        add_rules(m, self.i, Assume)
        has = Signal(COUNT)
        takes = Signal(COUNT)
        for k, output in enumerate(dut.o):
            m.d.comb += [takes[k].eq(output.valid & output.ready), Assert(~output.valid | self.i.valid),
                         Assert(~output.valid | (Value.cast(output.payload) == Value.cast(self.i.payload)))]
            # Nobody waits for another output's sake.
            with m.If(self.i.valid & ~has[k]):
                m.d.comb += Assert(output.valid)
        m.d.comb += Assert(~(takes & has).any())
        with m.If(self.i.valid & self.i.ready):
            m.d.sync += has.eq(0)
            m.d.comb += [Assert((takes | has).all()), Cover((has == 0b010) & (takes == 0b101))]
        with m.Else():
            m.d.sync += has.eq(has | takes)
        with m.If(self.i.valid & (takes | has).all()):
            m.d.comb += Assert(self.i.ready)
        return m


FAULTS = {
    "gives an item twice": {"o__1__valid": lambda dut: dut.i.valid},
    "forgets an output": {"i__ready": lambda dut: dut.o[0].ready & dut.o[1].ready},
    "waits for another output": {"o__2__valid": lambda dut: dut.o[2].valid & dut.o[0].ready},
    "gives the wrong item": {"o__2__payload": lambda dut: 0},
}


def test_each_output_once():
    assert prove(ForkOnce(Fork(SHAPE, count=COUNT)))


def test_reaches_different_cycles():
    assert prove(ForkOnce(Fork(SHAPE, count=COUNT)), mode="cover", depth=6)


@pytest.mark.parametrize("fault", FAULTS)
def test_negative_control(fault):
    assert not prove(ForkOnce(NegativeControl(Fork(SHAPE, count=COUNT), FAULTS[fault])), mode="bmc", depth=6)
