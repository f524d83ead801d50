from itertools import permutations

import pytest
from amaranth.hdl import Assert, Assume, Cat, Cover, Module, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In

from hw.lib.arbiter import Arbiter, ArbiterPolicy
from hw.lib.round_robin import RoundRobin
from tb.formal.around import connect_ports
from tb.formal.follow import follow
from tb.formal.prove import prove
from tb.formal.stream_rules import add_rules
from tb.formal.twin import Twin

COUNT = 3
POLICIES = list(ArbiterPolicy)


class ArbiterFair(wiring.Component):
    """One of the inputs goes whenever one can, at most one, the right one; and it comes out."""

    def __init__(self, dut, policy):
        self._dut, self._policy = dut, policy
        super().__init__({**dict(dut.signature.members.items()), "marks": In(1)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = dut = self._dut
        connect_ports(m, self, dut)
        asks, goes, item = Signal(COUNT), Signal(COUNT), Signal(len(dut.o.payload.as_value()))
        for k in range(COUNT):
            add_rules(m, self.i[k], Assume)
            m.d.comb += [asks[k].eq(dut.i[k].valid), goes[k].eq(dut.i[k].valid & dut.i[k].ready)]
            with m.If(goes[k]):
                view = type(dut.o.payload)(dut.o.payload.shape(), item)
                m.d.comb += [view.source.eq(k), view.item.eq(dut.i[k].payload)]

        can = asks.any() & (dut.o.ready | ~dut.o.valid)
        m.d.comb += [Assert((goes & (goes - 1)) == 0), Assert(goes.any() == can)]
        follow(m, goes.any(), item, dut.o.valid & dut.o.ready, dut.o.payload, room=1, marks=self.marks)
        m.d.comb += Cover(goes.any() & asks.all() & self.marks)

        for k in range(COUNT):
            # Items of others that went while this one waited.
            others = Signal(range(COUNT + 1), name=f"others_{k}")
            with m.If(goes[k] | ~asks[k]):
                m.d.sync += others.eq(0)
            with m.Elif(goes.any()):
                m.d.sync += others.eq(others + (others != COUNT))
            m.d.comb += [Assert(others < COUNT), Cover((others == COUNT - 1) & goes[k])]
        if self._policy is ArbiterPolicy.LONGEST_WAITING:
            self._first_come(m, asks, goes)
        else:
            self._in_turn(m, asks, goes)
        return m

    def _first_come(self, m, asks, goes):
        waited = Signal(COUNT)
        m.d.sync += waited.eq(asks & ~goes)
        for a, b in permutations(range(COUNT), 2):
            # a asked in an earlier cycle than b, or in the same one and has the smaller number.
            earlier, kept = Signal(name=f"{a}_before_{b}"), Signal(name=f"{a}_was_before_{b}")
            m.d.sync += kept.eq(earlier)
            with m.If(waited[a] & waited[b]):
                m.d.comb += earlier.eq(kept)
            with m.Elif(waited[a] | waited[b]):
                m.d.comb += earlier.eq(waited[a])
            with m.Else():
                m.d.comb += earlier.eq(a < b)
            with m.If(goes[b] & asks[a]):
                m.d.comb += Assert(~earlier)

    def _in_turn(self, m, asks, goes):
        last, known = Signal(range(COUNT)), Signal()
        for k in range(COUNT):
            with m.If(goes[k]):
                m.d.sync += [last.eq(k), known.eq(1)]
                for before in range(COUNT):
                    between = [(before + step) % COUNT for step in range(1, (k - before - 1) % COUNT + 1)]
                    with m.If(known & (last == before)):
                        m.d.comb += Assert(~Cat(asks[j] for j in between).any())


class _LowestFirst(RoundRobin):
    def elaborate(self, platform):
        m = Module()
        m.d.comb += self.grant.eq(self.eligible & ~(self.eligible - 1))
        return m


class _AllFirst(RoundRobin):
    def elaborate(self, platform):
        m = Module()
        m.d.comb += self.grant.eq(self.eligible)
        return m


@pytest.mark.parametrize("policy", POLICIES)
def test_fair_and_complete(policy):
    assert prove(ArbiterFair(Arbiter(2, count=COUNT, policy=policy), policy))


@pytest.mark.parametrize("policy", POLICIES)
def test_reaches_the_bound(policy):
    assert prove(ArbiterFair(Arbiter(2, count=COUNT, policy=policy), policy), mode="cover", depth=10)


@pytest.mark.parametrize("policy", POLICIES)
@pytest.mark.parametrize("broken", [_LowestFirst, _AllFirst])
def test_broken_twin(broken, policy, monkeypatch):
    monkeypatch.setattr(ArbiterPolicy, "rule", broken)
    assert not prove(ArbiterFair(Arbiter(2, count=COUNT, policy=policy), policy), mode="bmc", depth=10)


@pytest.mark.parametrize("policy", POLICIES)
def test_the_other_policy_is_noticed(policy):
    other, = (one for one in POLICIES if one is not policy)
    assert not prove(ArbiterFair(Arbiter(2, count=COUNT, policy=other), policy), mode="bmc", depth=10)


def test_wrong_source():
    twin = Twin(Arbiter(2, count=COUNT), {"o__payload": lambda dut: Value.cast(dut.o.payload) ^ dut.o.ready})
    assert not prove(ArbiterFair(twin, ArbiterPolicy.ROUND_ROBIN), mode="bmc", depth=6)
