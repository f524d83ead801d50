import pytest
from amaranth.hdl import Assert, Assume, Const, Cover, Module, Mux, Signal
from amaranth.lib import wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In

from hw.lib.update_memory import UpdateMemory
from tb.formal.connect_ports import connect_ports
from tb.formal.negative_control import NegativeControl
from tb.formal.prove import prove

OPERAND = StructLayout({"key": 2, "hit": 1, "clear": 1})


def nearest(old, operand):
    """The larger key stays; a clear makes it 0."""
    return Mux(operand.clear, 0, operand.key), operand.clear | (operand.hit & (operand.key > old))


class Nearest(wiring.Component):
    """No nearer hit is ever lost: each item of any one row finds the best of all items before it since the row was
    cleared.

    What a reset leaves in the memory may be anything.
    """

    def __init__(self, dut, depth):
        self._dut, self._depth = dut, depth
        super().__init__({**dict(dut.signature.members.items()), "row": In(range(depth))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = dut = self._dut
        connect_ports(m, self, dut)
        row, chosen = Signal(range(self._depth)), Signal()
        m.d.sync += chosen.eq(1)
        with m.If(~chosen):
            m.d.sync += row.eq(self.row)
        item = dut.i.payload
        m.d.comb += Assume(item.address < self._depth)

        # The best so far as golden has it: one item after the other, each at once.
        best, known = Signal(2), Signal()
        mine = chosen & dut.i.valid & (item.address == row)
        new, written = nearest(best, item.operand)
        with m.If(mine & written):
            m.d.sync += best.eq(new)
        with m.If(mine & item.operand.clear):
            m.d.sync += known.eq(1)
        expected = {"asks": mine & known, "best": best, "written": written}
        for age in range(1, dut.latency + 1):
            later = {name: Signal(2 if name == "best" else 1, name=f"{name}_{age}") for name in expected}
            m.d.sync += [later[name].eq(expected[name]) for name in expected]
            expected = later
        got = dut.o.payload
        with m.If(expected["asks"]):
            m.d.comb += [Assert(dut.o.valid), Assert(got.address == row), Assert(got.old == expected["best"]),
                         Assert(got.written == expected["written"])]
            with m.If(got.written):
                m.d.comb += Assert(got.new == nearest(got.old, got.tag)[0])
        m.d.comb += Cover(expected["asks"] & ~expected["written"] & (expected["best"] == 3))
        return m


def make(kind=UpdateMemory, depth=3):
    # The operand is the tag too, so that the new row is known.
    return kind(2, depth=depth, operand=OPERAND, tag=OPERAND, change=nearest)


class Same(wiring.Component):
    """Gives each item its operand as the tag."""

    def __init__(self, dut):
        self._dut, self.latency = dut, dut.latency
        super().__init__(dut.signature)

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = dut = self._dut
        connect_ports(m, self, dut)
        m.d.comb += dut.i.payload.tag.eq(self.i.payload.operand)
        return m


def blind(*aheads):
    """An update memory that does not look at the items so many cycles ahead."""
    class Blind(UpdateMemory):
        def _same_as(self, m, addresses, ahead, *, age):
            return Const(0) if ahead in aheads else super()._same_as(m, addresses, ahead, age=age)

    return Blind


@pytest.mark.parametrize("depth", [2, 3])
def test_the_nearest_hit_is_never_lost(depth):
    assert prove(Nearest(Same(make(depth=depth)), depth), mode="bmc", depth=14)


def test_reaches_the_largest_key():
    assert prove(Nearest(Same(make()), 3), mode="cover", depth=10)


@pytest.mark.parametrize("ahead", [1, 2, 3, 4])
def test_without_a_look_ahead(ahead):
    proof = prove(Nearest(Same(make(blind(ahead))), 3), mode="bmc", depth=14)
    assert not proof
    assert proof.trace


def test_negative_control():
    control = NegativeControl(Same(make()), {"o__valid": lambda dut: dut.o.valid & ~dut.i.valid})
    control.latency = 4
    assert not prove(Nearest(control, 3), mode="bmc", depth=14)
