from itertools import permutations

import pytest
from amaranth.hdl import Assert, Assume, Cat, Cover, Module, Signal, Value
from amaranth.lib import wiring
from amaranth.lib.wiring import In

from hw.lib.arbiter import Arbiter, ArbiterPolicy
from hw.lib.round_robin import RoundRobin
from tb.formal.connect_ports import connect_ports
from tb.formal.fifo_order import add_fifo_order
from tb.formal.negative_control import NegativeControl
from tb.formal.prove import prove
from tb.formal.stream_rules import add_rules

COUNT = 3
POLICIES = list(ArbiterPolicy)


class ArbiterFair(wiring.Component):
    """Whenever a grant is possible, exactly one eligible input is granted, the right one; its item comes out."""

    def __init__(self, dut, policy):
        self._dut, self._policy = dut, policy
        super().__init__({**dict(dut.signature.members.items()), "mark": In(1)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = dut = self._dut
        connect_ports(m, self, dut)
        requests, grants, item = Signal(COUNT), Signal(COUNT), Signal(len(dut.o.payload.as_value()))
        for k in range(COUNT):
            add_rules(m, self.i[k], Assume)
            m.d.comb += [requests[k].eq(dut.i[k].valid), grants[k].eq(dut.i[k].valid & dut.i[k].ready)]
            with m.If(grants[k]):
                view = type(dut.o.payload)(dut.o.payload.shape(), item)
                m.d.comb += [view.source.eq(k), view.item.eq(dut.i[k].payload)]

        possible = requests.any() & (dut.o.ready | ~dut.o.valid)
        m.d.comb += [Assert((grants & (grants - 1)) == 0), Assert(grants.any() == possible)]
        add_fifo_order(m, push=grants.any(), pushed=item, pop=dut.o.valid & dut.o.ready, popped=dut.o.payload,
                       capacity=1, mark=self.mark)
        m.d.comb += Cover(grants.any() & requests.all() & self.mark)

        for k in range(COUNT):
            # Grants of others while this one waited.
            others = Signal(range(COUNT + 1), name=f"others_{k}")
            with m.If(grants[k] | ~requests[k]):
                m.d.sync += others.eq(0)
            with m.Elif(grants.any()):
                m.d.sync += others.eq(others + (others != COUNT))
            m.d.comb += [Assert(others < COUNT), Cover((others == COUNT - 1) & grants[k])]
        if self._policy is ArbiterPolicy.LONGEST_WAITING:
            self._first_come(m, requests, grants)
        else:
            self._round_robin(m, requests, grants)
        return m

    def _first_come(self, m, requests, grants):
        waited = Signal(COUNT)
        m.d.sync += waited.eq(requests & ~grants)
        for a, b in permutations(range(COUNT), 2):
            # a requested in an earlier cycle than b, or in the same one and has the smaller number.
            earlier, kept = Signal(name=f"{a}_before_{b}"), Signal(name=f"{a}_was_before_{b}")
            m.d.sync += kept.eq(earlier)
            with m.If(waited[a] & waited[b]):
                m.d.comb += earlier.eq(kept)
            with m.Elif(waited[a] | waited[b]):
                m.d.comb += earlier.eq(waited[a])
            with m.Else():
                m.d.comb += earlier.eq(a < b)
            with m.If(grants[b] & requests[a]):
                m.d.comb += Assert(~earlier)

    def _round_robin(self, m, requests, grants):
        last, known = Signal(range(COUNT)), Signal()
        for k in range(COUNT):
            with m.If(grants[k]):
                m.d.sync += [last.eq(k), known.eq(1)]
                for before in range(COUNT):
                    between = [(before + step) % COUNT for step in range(1, (k - before - 1) % COUNT + 1)]
                    with m.If(known & (last == before)):
                        m.d.comb += Assert(~Cat(requests[j] for j in between).any())


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
def test_negative_control(broken, policy, monkeypatch):
    monkeypatch.setattr(ArbiterPolicy, "rule", broken)
    assert not prove(ArbiterFair(Arbiter(2, count=COUNT, policy=policy), policy), mode="bmc", depth=10)


@pytest.mark.parametrize("policy", POLICIES)
def test_the_other_policy_is_noticed(policy):
    other, = (one for one in POLICIES if one is not policy)
    assert not prove(ArbiterFair(Arbiter(2, count=COUNT, policy=other), policy), mode="bmc", depth=10)


def test_wrong_source():
    faults = {"o__payload": lambda dut: Value.cast(dut.o.payload) ^ dut.o.ready}
    control = NegativeControl(Arbiter(2, count=COUNT), faults)
    assert not prove(ArbiterFair(control, ArbiterPolicy.ROUND_ROBIN), mode="bmc", depth=6)
