from amaranth.hdl import Array, Assert, Assume, Cat, Cover, Signal

from hw.memsys.patches.deferred_store import DeferredStore
from tb.formal.bench import Bench, transfers
from tb.formal.declare import Claim, Control, declare
from tb.formal.stream_rules import add_rules


def released_once(m, bench, dut, depth, owners):
    """An item leaves once, when its chain has been released, with the data of the release, in a bounded time, and until
    then ``releases`` says that it is due.

    Chains belong to owners, who remember them; the tag of any one item at a time is 1, of all others 0. ``adds`` and
    ``frees`` say whose chain gets an item and whose is released.
    """
    add_rules(m, dut.o, Assert)
    adds, frees = (bench.free(range(owners), name) for name in ("adds", "frees"))
    chains = Array(Signal(dut.chain, name=f"chain_{k}") for k in range(owners))
    released = dut.i_release.payload
    m.d.comb += [Assume(adds < owners), Assume(frees < owners),
                 dut.i.payload.chain.eq(chains[adds]), dut.i.payload.tag.eq(bench.free(1, "tag")),
                 released.chain.eq(chains[frees]), released.data.eq(bench.free(1, "data")),
                 dut.i_release.valid.eq(bench.free(1, "releases") & chains[frees].some),
                 dut.i.valid.eq(bench.free(1, "offers") & ~(dut.i_release.valid & (adds == frees)))]
    takes, gives = transfers(dut.i), transfers(dut.o)
    with m.If(takes):
        m.d.sync += chains[adds].eq(dut.longer)
    with m.If(dut.i_release.valid):
        m.d.sync += chains[frees].some.eq(0)

    # How many are inside, one of them perhaps at the output.
    inside = Signal(range(depth + 3))
    m.d.sync += inside.eq(inside + takes - gives)
    m.d.comb += [Assert(inside == dut.waiting + dut.o.valid, "count"),
                 Assert(dut.i.ready == (dut.waiting != depth), "capacity")]

    # The item: it is due when its chain is released.
    out, due, owner, expected = Signal(), Signal(), Signal(range(owners)), Signal()
    mine, freed = takes & dut.i.payload.tag, dut.i_release.valid & (frees == owner)
    m.d.comb += [Assume(~mine | ~out), Assert(~(out & (due | freed)) | dut.releases, "releases")]
    with m.If(mine):
        m.d.sync += [out.eq(1), owner.eq(adds)]
    with m.If(out & ~due & freed):
        m.d.sync += [due.eq(1), expected.eq(released.data)]
    with m.If(dut.o.valid & dut.o.payload.tag):
        m.d.comb += [Assert(out & due, "once"), Assert(dut.o.payload.data == expected, "data")]
    with m.If(gives & dut.o.payload.tag):
        m.d.sync += [out.eq(0), due.eq(0)]

    # Every item that is due leaves; those before it take a cycle each.
    late, bound = Signal(range(depth + 4)), depth + 2
    with m.If(~due):
        m.d.sync += late.eq(0)
    with m.Elif(dut.o.ready & (late != bound + 1)):
        m.d.sync += late.eq(late + 1)
    m.d.comb += [Assert(late <= bound, "bound"), Cover(late == bound, "the bound")]


def make(depth=2, owners=2):
    return Bench(released_once, DeferredStore(1, depth=depth, tag=1), depth=depth, owners=owners)


test_deferred_store = declare(
    make, cycles=12, engine="abc bmc3", covers_nightly=True,
    claims=[Claim(depth=1, unbounded=True), Claim(cycles=10), Claim(cycles=14, nightly=True),
            Claim(depth=3, nightly=True)],
    controls={
        "accepts an item when it is full": Control("capacity", {"i__ready": lambda dut: 1}, nightly=True),
        "forgets who waits already": Control(
            "bound", {"longer": lambda dut: Cat(1, dut.longer.last, dut.longer.last)}, nightly=True),
        "forgets who comes": Control("bound", {"longer": lambda dut: Cat(1, dut.longer.first, dut.longer.first)}),
        "gives an item twice": Control(
            "once", {"o__valid": lambda dut: dut.o.valid | (dut.waiting == 2)}, nightly=True),
        "gives other data": Control(
            "data", {"o__payload": lambda dut: dut.o.payload.as_value() ^ ((dut.waiting == 1) << 1)}, nightly=True),
        "says too early that all have left": Control(
            "releases", {"releases": lambda dut: dut.i_release.valid | dut.o.valid}),
        "keeps an item": Control("bound", {"o__valid": lambda dut: dut.o.valid & (dut.waiting != 2)}, nightly=True),
        "counts wrongly": Control(
            "count", {"waiting": lambda dut: dut.waiting + (dut.i.valid & dut.o.valid)}, nightly=True),
    })
