# amaranth: UnusedElaboratable=no

import pytest
from amaranth.hdl import Assert, Assume, Cover, Module, Signal
from amaranth.lib import wiring

from hw.memsys.work_count import WorkCount
from tb.formal.connect_ports import connect_ports
from tb.formal.negative_control import NegativeControl
from tb.formal.prove import prove


class ExactCount(wiring.Component):
    """Items told apart: those that came through each place, and those that left. ``empty`` if and only if all had left
    a cycle ago.
    """

    def __init__(self, dut, most):
        self._dut, self._most = dut, most
        super().__init__(dut.signature)

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = dut = self._dut
        connect_ports(m, self, dut)
        # Totals modulo 64; that no more are inside than there is room for makes their difference exact.
        came, left, late = Signal(6), Signal(6), Signal.like(self.leaves)
        m.d.sync += [came.eq(came + sum(self.enters)), late.eq(self.leaves), left.eq(left + sum(late))]
        inside, after = Signal(6), Signal(8)
        m.d.comb += [inside.eq(came - left), after.eq(inside + sum(self.enters) - sum(late)),
                     Assume(sum(self.leaves) + sum(late) <= inside), Assume(after <= self._most),
                     Assert(dut.level == inside), Assert(dut.empty == (came == left)),
                     Cover((inside == self._most) & self.enters.any() & self.leaves.all())]
        return m


@pytest.mark.parametrize(("enters", "leaves", "most"), [
    (2, 3, 7), pytest.param(1, 1, 1, marks=pytest.mark.nightly), pytest.param(1, 4, 9, marks=pytest.mark.nightly)])
def test_empty_exactly_when_all_have_left(enters, leaves, most):
    assert prove(ExactCount(WorkCount(enters=enters, leaves=leaves, most=most), most))


@pytest.mark.nightly
def test_reaches_the_last_entry():
    assert prove(ExactCount(WorkCount(enters=2, leaves=2, most=5), 5), mode="cover", depth=10)


FAULTS = {"one that is early": {"empty": lambda dut: (dut.level == 0) | ((dut.level == 1) & dut.leaves[0])},
          "one that counts one place": {"level": lambda dut: dut.level - (dut.level == 3)}}


@pytest.mark.parametrize("fault", FAULTS)
def test_negative_control(fault):
    control = NegativeControl(WorkCount(enters=2, leaves=2, most=5), FAULTS[fault])
    assert not prove(ExactCount(control, 5), mode="bmc", depth=8)


@pytest.mark.parametrize("name", ["enters", "leaves", "most"])
def test_init_wrong(name):
    with pytest.raises(ValueError, match=f"^{name.capitalize()} must be at least 1, not 0$"):
        WorkCount(**{"enters": 1, "leaves": 1, "most": 1, name: 0})
