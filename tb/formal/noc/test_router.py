from types import SimpleNamespace

from amaranth.hdl import Assert, Assume, Cover, Module, Signal

from golden.engine.noc.routing import route
from golden.engine.noc.topology import Topology
from hw.lib.arbiter import ArbiterPolicy
from hw.lib.round_robin import RoundRobin
from hw.noc.input_queue import InputQueue
from hw.noc.router import Router
from tb.formal.bench import Bench
from tb.formal.declare import Claim, Control, declare
from tb.formal.source_fault import with_parts

DEPTH = 2
# A node with one link, and one between two others: topology, nodes, which one, kinds of messages. All ports have links:
# what came in at one without could never leave.
NETWORKS = {"end": ("hypercube", 2, 0, 2), "interior": ("mesh", 3, 1, 1)}
IN_TURN, BY_AGE = ArbiterPolicy.ROUND_ROBIN, ArbiterPolicy.LONGEST_WAITING
# Cycles without a flit from a queue that has some, with neighbours that return a credit at once. In turn there is a
# bound where an output has one channel: with two a queue is skipped while its channel has no credit. The cycles of the
# router are the last part of a key.
LIMITS = {("interior", IN_TURN, 1): 4, ("interior", IN_TURN, 2): 6, ("interior", BY_AGE, 1): 5,
          ("interior", BY_AGE, 2): 7, ("end", BY_AGE, 1): 4, ("end", BY_AGE, 2): 4}


def credits_kept(m, bench, dut, router_cycles, limit=None):
    """Flits that come in, in packets and within their credits, leave once, in packets and within the credits.

    ``limit``: every flit continues within so many cycles, if the neighbours return credits at once, and packets have
    one flit, so that none waits for the rest of another one.
    """
    sent, given_back = [], []
    for port in range(len(dut.i)):
        for channel in range(len(dut.i_credit[port])):
            name = f"{port}_{channel}"
            comes, goes = _flit(dut.i[port], channel), _flit(dut.o[port], channel)
            back, credit = dut.o_credit[port][channel], dut.i_credit[port][channel]
            _whole(m, comes, dut.i[port].payload.flit, Assume, f"in_{name}")
            inside = _count(m, comes, back, f"in_{name}")
            m.d.comb += [Assume(inside <= DEPTH), Assert(~((inside == 0) & back), "entry")]

            _whole(m, goes, dut.o[port].payload.flit, Assert, f"out_{name}")
            outside = _count(m, goes, credit, f"out_{name}")
            m.d.comb += [Assert(outside <= DEPTH, "credit"), Assume(~((outside == 0) & credit))]
            if limit is None:
                m.d.comb += Cover((outside == DEPTH) & (inside == DEPTH), f"full {name}")
            else:
                m.d.comb += [Assume((outside == 0) | credit), Assume(dut.i[port].payload.flit.last)]
                _waits(m, inside, back, limit, name)
            sent.append(goes)
            given_back.append(back)
    # For each credit that is returned a flit is sent in the same cycle, or in the next one.
    gone = sum(given_back)
    if router_cycles == 2:
        before = Signal(range(len(sent) + 1))
        m.d.sync += before.eq(gone)
        gone = before
    m.d.comb += Assert(sum(sent) == gone, "flit")


def _flit(link, channel):
    return link.valid & (link.payload.channel == channel)


def _count(m, more, less, name):
    """Flits whose credit has not been returned."""
    count = Signal(range(DEPTH + 3), name=f"count_{name}")
    m.d.sync += count.eq(count + more - less)
    return count


def _whole(m, comes, flit, check, name):
    """A packet's first flit comes when none is being sent."""
    within = Signal(name=f"within_{name}")
    with m.If(comes):
        m.d.sync += within.eq(~flit.last)
        m.d.comb += check(flit.first == ~within, "packet")


def _waits(m, inside, back, limit, name):
    """No queue waits for long."""
    waits = Signal(range(limit + 2), name=f"waits_{name}")
    with m.If((inside == 0) | back):
        m.d.sync += waits.eq(0)
    with m.Else():
        m.d.sync += waits.eq(waits + (waits <= limit))
    m.d.comb += [Assert(waits <= limit, "progress"), Cover(waits == limit - 1, f"nearly waits too long {name}")]


class LastAlways(InputQueue):
    def elaborate(self, platform):
        m = super().elaborate(platform)
        m.d.comb += self.front.last.eq(1)
        return m


class LowestFirst(RoundRobin):
    def elaborate(self, platform):
        m = Module()
        m.d.comb += self.grant.eq(self.eligible & ~(self.eligible - 1))
        return m


def make(where="interior", router_cycles=2, policy=IN_TURN, depth=DEPTH, kind=Router, rule=None, **more):
    topology, columns, node, messages = NETWORKS[where]
    dut = kind(routing=route(Topology(topology, columns, 1), 1), node=node, bits=2, depth=depth, messages=messages,
               router_cycles=router_cycles, policy=policy)
    if rule:
        dut._policy = SimpleNamespace(rule=rule)
    return Bench(credits_kept, dut, router_cycles=router_cycles, **more)


def make_bounded(where="interior", policy=IN_TURN, router_cycles=2, limit=None, **more):
    return make(where, policy=policy, router_cycles=router_cycles, limit=limit or LIMITS[where, policy, router_cycles],
                **more)


test_credits = declare(
    make, cycles=10, engine="abc bmc3", covers_nightly=True,
    claims=[Claim(router_cycles=1, cycles=8), Claim(router_cycles=2), *(
        Claim(where=where, policy=policy, router_cycles=cycles, cycles=14 if cycles == 2 else 12, nightly=True)
        for where in NETWORKS for policy in ArbiterPolicy for cycles in (1, 2))],
    controls={
        "too many entries": Control("credit", depth=2 * DEPTH),
        "a credit returned twice": Control(
            "entry", {"o_credit__0": lambda dut: dut.o_credit[0] | dut.o[1].valid}),
        "a credit that is not returned": Control(
            "flit", {"o_credit__1": lambda dut: dut.o_credit[1][0:0]}, nightly=True),
        "a lost flit": Control("flit", {"o__0__valid": lambda dut: dut.o[0].valid & ~dut.o[0].payload.flit.first}),
        "packets in each other": Control("packet", kind=with_parts(Router, InputQueue=LastAlways)),
    })
test_progress = declare(
    make_bounded, cycles=16, engine="abc bmc3", covers_nightly=True,
    claims=[Claim(policy=policy) for policy in ArbiterPolicy] + [
        Claim(where=where, policy=policy, router_cycles=cycles, nightly=True) for where, policy, cycles in LIMITS],
    controls={
        "a shorter bound in turn": Control("progress", limit=LIMITS["interior", IN_TURN, 2] - 1),
        **{f"a shorter bound {words} in one cycle": Control(
            "progress", policy=policy, router_cycles=1, limit=LIMITS["interior", policy, 1] - 1, nightly=True)
           for words, policy in (("in turn", IN_TURN), ("by age", BY_AGE))},
        "a shorter bound by age": Control(
            "progress", where="end", policy=BY_AGE, limit=LIMITS["end", BY_AGE, 2] - 1, nightly=True),
        "in turn over two channels": Control(
            "progress", where="end", limit=2 * LIMITS["end", BY_AGE, 2], nightly=True),
        "an input that is never granted": Control("progress", rule=LowestFirst, nightly=True),
    })
