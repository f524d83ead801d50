from amaranth.hdl import Assert, Assume, Const, Cover, Mux, Signal
from amaranth.lib.data import StructLayout

from hw.lib.update_memory import UpdateMemory
from tb.formal.bench import Bench
from tb.formal.declare import Claim, Control, declare

OPERAND = StructLayout({"key": 2, "hit": 1, "clear": 1})


def change(_, old, operand):
    """The larger key stays; a clear makes it 0."""
    return Mux(operand.clear, 0, operand.key), operand.clear | (operand.hit & (operand.key > old))


def nearest(m, bench, dut, depth):
    """No nearer hit is ever lost: each item of any one row finds the best of all items before it since the row was
    cleared.

    What a reset leaves in the memory may be anything.
    """
    row, chosen = bench.choose(m, range(depth), "row"), Signal()
    # The operand is the tag too, so that the new row is known.
    item, operand = dut.i.payload, bench.free(OPERAND, "operand")
    m.d.sync += chosen.eq(1)
    m.d.comb += [item.address.eq(bench.free(range(depth), "address")), item.operand.eq(operand), item.tag.eq(operand),
                 Assume(item.address < depth)]

    # The best so far as golden has it: one item after the other, each at once.
    best, known = Signal(2), Signal()
    mine = chosen & dut.i.valid & (item.address == row)
    new, written = change(None, best, operand)
    with m.If(mine & written):
        m.d.sync += best.eq(new)
    with m.If(mine & operand.clear):
        m.d.sync += known.eq(1)
    expected = {"requests": mine & known, "best": best, "written": written}
    for age in range(1, dut.latency + 1):
        later = {name: Signal(2 if name == "best" else 1, name=f"{name}_{age}") for name in expected}
        m.d.sync += [later[name].eq(expected[name]) for name in expected]
        expected = later
    got = dut.o.payload
    with m.If(expected["requests"]):
        m.d.comb += [Assert(dut.o.valid, "latency"), Assert(got.address == row, "latency"),
                     Assert(got.old == expected["best"], "old"), Assert(got.written == expected["written"], "written")]
        with m.If(got.written):
            m.d.comb += Assert(got.new == change(None, got.old, got.tag)[0], "new")
    m.d.comb += Cover(expected["requests"] & ~expected["written"] & (expected["best"] == 3), "the largest key")


def blind(*aheads):
    """An update memory that does not look at the items so many cycles ahead."""
    class Blind(UpdateMemory):
        def _same_as(self, m, addresses, ahead, *, age):
            return Const(0) if ahead in aheads else super()._same_as(m, addresses, ahead, age=age)

    return Blind


def make(depth=3, kind=UpdateMemory):
    return Bench(nearest, kind(2, depth=depth, operand=OPERAND, tag=OPERAND, change=change), depth=depth)


test_update_memory = declare(
    make, cycles=14, claims=[Claim(depth=2), Claim(depth=3)],
    controls={
        **{f"does not look {ahead} items ahead": Control("old", kind=blind(ahead), nightly=ahead > 1)
           for ahead in (1, 2, 3, 4)},
        "loses an item": Control("latency", {"o__valid": lambda dut: dut.o.valid & ~dut.i.valid}),
    })
