import pytest
from amaranth.hdl import Array, Assert, Assume, Cat, Cover, Module, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In

from hw.memsys.deferred_store import DeferredStore
from tb.formal.connect_ports import connect_ports
from tb.formal.negative_control import NegativeControl
from tb.formal.prove import prove
from tb.formal.stream_rules import add_rules

ENGINE = "abc bmc3"


class ReleasedOnce(wiring.Component):
    """An item leaves once, when its chain has been released, with the data of the release, in a bounded time.

    Chains belong to owners, who remember them; any one item at a time is told by its tag, which is 1. Inputs:
    ``adds`` and ``frees`` say whose chain gets an item and whose is released.
    """

    def __init__(self, dut, *, depth, owners):
        self._dut, self._depth, self._owners = dut, depth, owners
        super().__init__({**dict(dut.signature.members.items()), "adds": In(range(owners)), "frees": In(range(owners))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = dut = self._dut
        connect_ports(m, self, dut)
        add_rules(m, self.o, Assert)
        chains = Array(Signal(dut.chain, name=f"chain_{k}") for k in range(self._owners))
        released = dut.i_release.payload
        m.d.comb += [Assume(self.adds < self._owners), Assume(self.frees < self._owners),
                     dut.i.payload.chain.eq(chains[self.adds]), released.chain.eq(chains[self.frees]),
                     dut.i_release.valid.eq(self.i_release.valid & chains[self.frees].some),
                     dut.i.valid.eq(self.i.valid & ~(dut.i_release.valid & (self.adds == self.frees)))]
        takes, gives = dut.i.valid & dut.i.ready, dut.o.valid & dut.o.ready
        with m.If(takes):
            m.d.sync += chains[self.adds].eq(dut.longer)
        with m.If(dut.i_release.valid):
            m.d.sync += chains[self.frees].some.eq(0)

        # How many are inside, one of them perhaps at the output.
        inside = Signal(range(self._depth + 3))
        m.d.sync += inside.eq(inside + takes - gives)
        m.d.comb += [Assert(inside == dut.waiting + dut.o.valid), Assert(dut.i.ready == (dut.waiting != self._depth))]

        # The item: it is due when its chain is released.
        out, due, owner, expected = Signal(), Signal(), Signal(range(self._owners)), Signal()
        mine, freed = takes & dut.i.payload.tag, dut.i_release.valid & (self.frees == owner)
        m.d.comb += Assume(~mine | ~out)
        with m.If(mine):
            m.d.sync += [out.eq(1), owner.eq(self.adds)]
        with m.If(out & ~due & freed):
            m.d.sync += [due.eq(1), expected.eq(released.data)]
        with m.If(dut.o.valid & dut.o.payload.tag):
            m.d.comb += [Assert(out), Assert(due), Assert(dut.o.payload.data == expected)]
        with m.If(gives & dut.o.payload.tag):
            m.d.sync += [out.eq(0), due.eq(0)]

        # Every item that is due leaves; those before it take a cycle each.
        late, bound = Signal(range(self._depth + 4)), self._depth + 2
        with m.If(~due):
            m.d.sync += late.eq(0)
        with m.Elif(dut.o.ready & (late != bound + 1)):
            m.d.sync += late.eq(late + 1)
        m.d.comb += [Assert(late <= bound), Cover(late == bound)]
        return m


def make(depth, *, owners=2, faults=None):
    dut = DeferredStore(1, depth=depth, tag=1)
    if faults:
        control = NegativeControl(dut, faults)
        control.chain = dut.chain
        dut = control
    return ReleasedOnce(dut, depth=depth, owners=owners)


FAULTS = {
    "takes what it has no room for": {"i__ready": lambda dut: 1},
    "forgets who waits already": {"longer": lambda dut: Cat(1, dut.longer.last, dut.longer.last)},
    "forgets who comes": {"longer": lambda dut: Cat(1, dut.longer.first, dut.longer.first)},
    "gives an item twice": {"o__valid": lambda dut: dut.o.valid | (dut.waiting == 2)},
    "gives other data": {"o__payload": lambda dut: dut.o.payload.as_value() ^ ((dut.waiting == 1) << 1)},
    "keeps an item": {"o__valid": lambda dut: dut.o.valid & (dut.waiting != 2)},
    "counts wrongly": {"waiting": lambda dut: dut.waiting + (dut.i.valid & dut.o.valid)},
}


def test_each_item_is_released_once():
    assert prove(make(1))


@pytest.mark.parametrize(("depth", "cycles"), [
    (2, 10), pytest.param(2, 14, marks=pytest.mark.nightly), pytest.param(3, 12, marks=pytest.mark.nightly)])
def test_in_the_first_cycles(depth, cycles):
    assert prove(make(depth), mode="bmc", depth=cycles, engine=ENGINE)


@pytest.mark.nightly
def test_reaches_the_bound():
    assert prove(make(3), mode="cover", depth=16)


@pytest.mark.parametrize("fault", [
    pytest.param(fault, marks=[] if fault == "forgets who comes" else pytest.mark.nightly) for fault in FAULTS])
def test_negative_control(fault):
    proof = prove(make(2, faults=FAULTS[fault]), mode="bmc", depth=12, engine=ENGINE)
    assert not proof
    assert proof.trace
