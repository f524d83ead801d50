from itertools import permutations
from types import SimpleNamespace

from amaranth.hdl import Assert, Assume, Cat, Cover, Module, Signal, Value

from hw.lib.arbiter import Arbiter, ArbiterPolicy
from hw.lib.round_robin import RoundRobin
from tb.formal.bench import Bench, transfers
from tb.formal.declare import Claim, Control, declare
from tb.formal.fifo_order import add_fifo_order
from tb.formal.stream_rules import add_rules

COUNT = 3
IN_TURN, BY_AGE = ArbiterPolicy.ROUND_ROBIN, ArbiterPolicy.LONGEST_WAITING


def fair(m, bench, dut, policy):
    """Whenever a grant is possible, exactly one eligible input is granted, the right one; its item comes out."""
    mark = bench.free(1, "mark")
    requests, grants, item = Signal(COUNT), Signal(COUNT), Signal(len(dut.o.payload.as_value()))
    for k in range(COUNT):
        add_rules(m, dut.i[k], Assume)
        m.d.comb += [requests[k].eq(dut.i[k].valid), grants[k].eq(transfers(dut.i[k]))]
        with m.If(grants[k]):
            view = type(dut.o.payload)(dut.o.payload.shape(), item)
            m.d.comb += [view.source.eq(k), view.item.eq(dut.i[k].payload)]

    possible = requests.any() & (dut.o.ready | ~dut.o.valid)
    m.d.comb += [Assert((grants & (grants - 1)) == 0, "one"), Assert(grants.any() == possible, "busy"),
                 Cover(grants.any() & requests.all() & mark, "all request")]
    add_fifo_order(m, push=grants.any(), pushed=item, pop=transfers(dut.o), popped=dut.o.payload, capacity=1, mark=mark)
    for k in range(COUNT):
        # Grants of others while this one waited.
        others = Signal(range(COUNT + 1), name=f"others_{k}")
        with m.If(grants[k] | ~requests[k]):
            m.d.sync += others.eq(0)
        with m.Elif(grants.any()):
            m.d.sync += others.eq(others + (others != COUNT))
        m.d.comb += [Assert(others < COUNT, "bound"), Cover((others == COUNT - 1) & grants[k], "the bound")]
    (_first_come if policy is BY_AGE else _round_robin)(m, requests, grants)


def _first_come(m, requests, grants):
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
            m.d.comb += Assert(~earlier, "policy")


def _round_robin(m, requests, grants):
    last, known = Signal(range(COUNT)), Signal()
    for k in range(COUNT):
        with m.If(grants[k]):
            m.d.sync += [last.eq(k), known.eq(1)]
            for before in range(COUNT):
                between = [(before + step) % COUNT for step in range(1, (k - before - 1) % COUNT + 1)]
                with m.If(known & (last == before)):
                    m.d.comb += Assert(~Cat(requests[j] for j in between).any(), "policy")


class LowestFirst(RoundRobin):
    def elaborate(self, platform):
        m = Module()
        m.d.comb += self.grant.eq(self.eligible & ~(self.eligible - 1))
        return m


class AllFirst(RoundRobin):
    def elaborate(self, platform):
        m = Module()
        m.d.comb += self.grant.eq(self.eligible)
        return m


def make(policy=IN_TURN, real=None, rule=None):
    dut = Arbiter(2, count=COUNT, policy=real or policy)
    if rule:
        dut._policy = SimpleNamespace(rule=rule)
    return Bench(fair, dut, policy=policy)


test_arbiter = declare(
    make, cycles=10, claims=[Claim(policy=policy, unbounded=True) for policy in (IN_TURN, BY_AGE)],
    controls={
        **{f"{policy.name.lower()} with {rule.__name__}": Control(
            breaks, policy=policy, rule=rule, nightly=policy is BY_AGE)
           for policy in (IN_TURN, BY_AGE) for rule, breaks in ((LowestFirst, "bound"), (AllFirst, "one"))},
        "by age instead of in turn": Control("policy", policy=IN_TURN, real=BY_AGE),
        "in turn instead of by age": Control("policy", policy=BY_AGE, real=IN_TURN),
        "another source": Control("order", {"o__payload": lambda dut: Value.cast(dut.o.payload) ^ dut.o.ready}),
    })
