import pytest
from amaranth.hdl import Assert, Assume, Cover, Module, Signal, Value
from amaranth.lib import wiring

from hw.lib.credit_gate import CreditGate
from tb.formal.connect_ports import connect_ports
from tb.formal.negative_control import NegativeControl
from tb.formal.prove import prove
from tb.formal.stream_rules import add_rules


class CreditGateBound(wiring.Component):
    """Never more items on their way than credits; while there are fewer, items pass as if there were no gate."""

    def __init__(self, dut, credits):
        self._dut, self._credits = dut, credits
        super().__init__(dut.signature)

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = dut = self._dut
        connect_ports(m, self, dut)
        add_rules(m, self.i, Assume)
        add_rules(m, self.o, Assert)
        out = Signal(range(self._credits + 2))
        passes = dut.o.valid & dut.o.ready
        m.d.sync += out.eq(out + passes - dut.i_return.valid)
        with m.If(out == 0):
            m.d.comb += Assume(~dut.i_return.valid)
        free = out != self._credits
        m.d.comb += [
            Assert(out <= self._credits), Assert(dut.level == out), Assert(passes == (dut.i.valid & dut.i.ready)),
            Assert(dut.o.valid == (dut.i.valid & free)), Assert(dut.i.ready == (dut.o.ready & free)),
            Assert(Value.cast(dut.o.payload) == Value.cast(dut.i.payload)),
            Cover((out == self._credits) & dut.i.valid & dut.i_return.valid)]
        return m


@pytest.mark.parametrize("credits", [1, 2, 3, 4])
def test_never_more_than_credits(credits):
    assert prove(CreditGateBound(CreditGate(2, credits=credits), credits))


def test_reaches_the_last_credit():
    assert prove(CreditGateBound(CreditGate(2, credits=3), 3), mode="cover", depth=8)


def test_one_credit_too_many():
    assert not prove(CreditGateBound(CreditGate(2, credits=4), 3), mode="bmc", depth=8)


def test_negative_control():
    control = NegativeControl(CreditGate(2, credits=3), {"o__valid": lambda dut: dut.i.valid})
    assert not prove(CreditGateBound(control, 3), mode="bmc", depth=8)
