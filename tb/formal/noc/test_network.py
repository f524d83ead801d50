from amaranth.hdl import Assert, Assume, Cover, Signal

from golden.engine.noc.routing import route
from golden.engine.noc.topology import Topology
from hw.lib.arbiter import ArbiterPolicy
from hw.noc.network import Network
from tb.formal.bench import Bench
from tb.formal.declare import Claim, Control, declare

DEPTH, NODES = 1, 2
# Cycles without a delivery while flits are inside and nodes return each credit at once.
LIMIT = 8


def nothing_lost(m, bench, dut):
    """Every flit that enters any router leaves at its destination, once, within a bound, and no credit is made
    or lost, whatever nodes send within their credits.

    Packets are of one flit, whose data are its destination and a mark; one flit at a time has the mark. Nodes return
    credits at any time; for the bound, at once.
    """
    eager = bench.choose(m, 1, "eager")
    inside, sent, delivered, waits = Signal(5), [], [], Signal(range(LIMIT + 2))
    out = Signal()
    marked, arrived, entries = [], [], []
    for node in range(NODES):
        into, exits = dut.i[node], dut.o[node]
        comes, goes, flit, gone = into.valid, exits.valid, into.payload.flit, exits.payload.flit
        back, credit = dut.o_credit[node][0], dut.i_credit[node][0]
        entry, outside = (Signal(range(DEPTH + 3), name=f"{name}_{node}") for name in ("entry", "outside"))
        m.d.sync += [entry.eq(entry + comes - back), outside.eq(outside + goes - credit)]
        m.d.comb += [Assume(~comes | (flit.first & flit.last)), Assume(entry <= DEPTH),
                     Assume((outside != 0) | ~credit), Assume(~eager | (outside == 0) | credit),
                     Assert((entry != 0) | ~back, "entry"), Assert(outside <= DEPTH, "credit"),
                     Cover(goes & (outside == DEPTH - 1) & (inside > 2), f"much traffic {node}")]
        with m.If(goes):
            m.d.comb += [Assert(gone.data[0] == node, "node"), Assert(gone.first & gone.last, "packet")]
        sent.append(comes)
        entries.append(entry)
        delivered.append(goes)
        marked.append(comes & flit.data[1])
        arrived.append(goes & gone.data[1])
    mine, there = sum(marked), sum(arrived)
    m.d.comb += [Assume(mine + out <= 1), Assert(there <= out, "once"), Assert(sum(delivered) <= inside, "once"),
                 Cover(there & (inside > 1), "the mark arrives")]
    # A cycle after the last flit has left the nodes have all their credits again.
    quiet, busy = Signal(), Signal()
    m.d.sync += [quiet.eq((inside + sum(sent)) == 0), busy.eq(busy | (inside > 2))]
    with m.If(quiet):
        m.d.comb += [Assert(sum(entries) == 0, "returned"), Cover(busy, "all credits after much traffic")]
    m.d.sync += [out.eq(out + mine - there), inside.eq(inside + sum(sent) - sum(delivered))]
    with m.If((inside == 0) | (sum(delivered) != 0) | ~eager):
        m.d.sync += waits.eq(0)
    with m.Else():
        m.d.sync += waits.eq(waits + (waits <= LIMIT))
    m.d.comb += Assert(waits <= LIMIT, "progress")


def make(policy=ArbiterPolicy.ROUND_ROBIN):
    network = Network(routing=route(Topology("mesh", NODES, 1), 1), bits=2, depth=DEPTH, policy=policy)
    return Bench(nothing_lost, network)


test_network = declare(
    make, cycles=14, engine="abc bmc3", covers_nightly=True,
    claims=[Claim(), *(Claim(policy=policy, cycles=20, nightly=True) for policy in ArbiterPolicy)],
    controls={
        "a flit to the wrong node": Control(
            "node", {"o__1__payload": lambda dut: dut.o[1].payload.as_value() ^ dut.o[0].valid}),
        "a flit that is lost": Control("progress", {"o__0__valid": lambda dut: dut.o[0].valid & ~dut.o[1].valid}),
        "a flit twice": Control(
            "once", {"o__0__valid": lambda dut: dut.o[0].valid | dut.o[1].valid}, nightly=True),
        "a lost credit": Control("returned", {"o_credit__0": lambda dut: dut.o_credit[0] & ~dut.o[1].valid}),
        "a credit too many": Control(
            "entry", {"o_credit__0": lambda dut: dut.o_credit[0] | dut.o[1].valid}, nightly=True),
    })
