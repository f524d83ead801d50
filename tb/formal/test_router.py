# amaranth: UnusedElaboratable=no

import pytest
from amaranth.hdl import Assert, Assume, Cover, Module, Signal
from amaranth.lib import wiring

from golden.noc.routing import route
from golden.noc.topology import Topology
from hw.lib.arbiter import ArbiterPolicy
from hw.lib.round_robin import RoundRobin
from hw.noc import router as module
from hw.noc.input_queue import InputQueue
from hw.noc.router import Router
from tb.formal.connect_ports import connect_ports
from tb.formal.negative_control import NegativeControl
from tb.formal.prove import prove

DEPTH = 2
# A node with one link, and one between two others: topology, nodes, which one, kinds of messages. All ports have links:
# what came in at one without could never leave.
NETWORKS = {"end": ("hypercube", 2, 0, 2), "interior": ("mesh", 3, 1, 1)}
# Cycles without a flit from a queue that has some, with neighbours that give a place back at once. In turn there is a
# bound where an output has one channel: with two a queue is skipped while its channel has no credit.
ROUND_ROBIN, BY_AGE = ArbiterPolicy.ROUND_ROBIN, ArbiterPolicy.LONGEST_WAITING
PATIENCE = {("interior", ROUND_ROBIN): 6, ("interior", BY_AGE): 7, ("end", BY_AGE): 4}


def make(where, depth=DEPTH, cls=Router, **options):
    topology, columns, node, messages = NETWORKS[where]
    return cls(routing=route(Topology(topology, columns, 1), 1), node=node, bits=2, depth=depth, messages=messages,
               **options)


class RouterCredits(wiring.Component):
    """Whatever comes in, in packets and within its credits, goes out once, in packets and within the credits."""

    def __init__(self, dut, patience=None, router_cycles=2):
        self._dut, self._patience, self._router_cycles = dut, patience, router_cycles
        super().__init__(dut.signature)

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = dut = self._dut
        connect_ports(m, self, dut)
        sent, given_back = [], []
        for port in range(len(dut.i)):
            for channel in range(len(dut.i_credit[port])):
                comes = self._flit(dut.i[port], channel)
                self._whole(m, comes, dut.i[port].payload.flit, Assume, f"in_{port}_{channel}")
                inside = self._count(m, comes, dut.o_credit[port][channel], f"in_{port}_{channel}")
                m.d.comb += [Assume(inside <= DEPTH), Assert(~((inside == 0) & dut.o_credit[port][channel]))]
                if self._patience:
                    self._waits(m, inside, dut.o_credit[port][channel], f"{port}_{channel}")

                goes = self._flit(dut.o[port], channel)
                self._whole(m, goes, dut.o[port].payload.flit, Assert, f"out_{port}_{channel}")
                outside = self._count(m, goes, dut.i_credit[port][channel], f"out_{port}_{channel}")
                m.d.comb += [Assert(outside <= DEPTH), Cover((outside == DEPTH) & (inside == DEPTH)),
                             Assume(~((outside == 0) & dut.i_credit[port][channel]))]
                if self._patience:
                    m.d.comb += Assume((outside == 0) | dut.i_credit[port][channel])
                sent.append(goes)
                given_back.append(dut.o_credit[port][channel])
        # Each place that was given back is a flit that is sent in the same cycle, or in the next one.
        gone = sum(given_back)
        if self._router_cycles == 2:
            before = Signal(range(len(sent) + 1))
            m.d.sync += before.eq(gone)
            gone = before
        m.d.comb += Assert(sum(sent) == gone)
        return m

    @staticmethod
    def _flit(link, channel):
        return link.valid & (link.payload.channel == channel)

    @staticmethod
    def _count(m, more, less, name):
        """Flits that have not been given back a place."""
        count = Signal(range(DEPTH + 3), name=f"count_{name}")
        m.d.sync += count.eq(count + more - less)
        return count

    @staticmethod
    def _whole(m, comes, flit, rule, name):
        """A packet's first flit comes when none is being sent."""
        within = Signal(name=f"within_{name}")
        with m.If(comes):
            m.d.sync += within.eq(~flit.last)
            m.d.comb += rule(flit.first == ~within)

    def _waits(self, m, inside, credit, name):
        """No queue waits for long; packets of one flit, so that nobody waits for the rest of another's."""
        waits = Signal(range(self._patience + 2), name=f"waits_{name}")
        with m.If((inside == 0) | credit):
            m.d.sync += waits.eq(0)
        with m.Else():
            m.d.sync += waits.eq(waits + (waits <= self._patience))
        m.d.comb += Assert(waits <= self._patience)


class RouterProgress(RouterCredits):
    """Every flit goes on within so many cycles, if the neighbours take theirs."""

    def elaborate(self, platform):
        m = super().elaborate(platform)
        for link in self._dut.i:
            m.d.comb += Assume(link.payload.flit.last)
        return m


class _LastAlways(InputQueue):
    def elaborate(self, platform):
        m = super().elaborate(platform)
        m.d.comb += self.front.last.eq(1)
        return m


class _LowestFirst(RoundRobin):
    def elaborate(self, platform):
        m = Module()
        m.d.comb += self.grant.eq(self.eligible & ~(self.eligible - 1))
        return m


def bounded(bench, depth):
    return prove(bench, mode="bmc", depth=depth, engine="abc bmc3")


@pytest.mark.parametrize(("router_cycles", "depth"), [(1, 8), (2, 10)])
def test_no_entry_is_lost_or_used_twice(router_cycles, depth):
    assert bounded(RouterCredits(make("interior", router_cycles=router_cycles), router_cycles=router_cycles), depth)


@pytest.mark.nightly
@pytest.mark.parametrize("router_cycles", [1, 2])
@pytest.mark.parametrize("policy", list(ArbiterPolicy))
@pytest.mark.parametrize("where", NETWORKS)
def test_no_entry_is_lost_or_used_twice_in_longer_runs(where, policy, router_cycles):
    router = make(where, policy=policy, router_cycles=router_cycles)
    assert bounded(RouterCredits(router, router_cycles=router_cycles), 14 if router_cycles == 2 else 12)


def test_reaches_full_queues():
    assert prove(RouterCredits(make("interior")), mode="cover", depth=12)


@pytest.mark.parametrize("policy", list(ArbiterPolicy))
def test_every_flit_advances(policy):
    assert bounded(RouterProgress(make("interior", policy=policy), PATIENCE["interior", policy]), 16)


@pytest.mark.nightly
@pytest.mark.parametrize("router_cycles", [1, 2])
@pytest.mark.parametrize(("where", "policy"), PATIENCE)
def test_every_flit_advances_in_longer_runs(where, policy, router_cycles):
    router = make(where, policy=policy, router_cycles=router_cycles)
    assert bounded(RouterProgress(router, PATIENCE[where, policy], router_cycles), 16)


@pytest.mark.parametrize(("where", "policy"), [("interior", ROUND_ROBIN), ("end", BY_AGE)])
def test_the_bound_is_reached(where, policy):
    assert not bounded(RouterProgress(make(where, policy=policy), PATIENCE[where, policy] - 1), 16)


@pytest.mark.nightly
def test_round_robin_over_two_channels_waits_longer():
    assert not bounded(RouterProgress(make("end"), 2 * PATIENCE["end", BY_AGE]), 16)


def test_too_many_entries():
    assert not bounded(RouterCredits(make("interior", depth=2 * DEPTH)), 12)


@pytest.mark.parametrize("fault", [
    {"o_credit__0": lambda dut: dut.o_credit[0] | dut.o[1].valid}, {"o_credit__1": lambda dut: dut.o_credit[1][0:0]},
    {"o__0__valid": lambda dut: dut.o[0].valid & ~dut.o[0].payload.flit.first}])
def test_a_lost_flit_or_entry(fault):
    assert not bounded(RouterCredits(NegativeControl(make("interior"), fault)), 12)


def test_packets_in_each_other(monkeypatch):
    monkeypatch.setattr(module, "InputQueue", _LastAlways)
    assert not bounded(RouterCredits(make("interior")), 12)


def test_an_input_that_is_never_granted(monkeypatch):
    monkeypatch.setattr(ArbiterPolicy, "rule", _LowestFirst)
    assert not bounded(RouterProgress(make("interior"), PATIENCE["interior", ROUND_ROBIN]), 12)
