"""The filter: of any one number the first in each generation passes, and no other, in any traffic of others."""

from amaranth.hdl import Assert, Assume, Const, Cover, Module, Signal

from hw.lib.generations import Generations
from hw.lib.update_memory import UpdateMemory
from hw.memsys.patches.filter import Filter
from tb.formal.bench import Bench, transfers
from tb.formal.declare import Claim, Control, declare
from tb.formal.source_fault import source_fault, with_parts
from tb.formal.stream_rules import add_rules

# A number of the second generation leaves in cycle 21 at the earliest; with few numbers in flight the proof gets there.
BITS, COUNT, WORD, CAPACITY = 2, 4, 2, 2


def once_per_generation(m, bench, dut):
    """Follows one number. Numbers leave in the order in which they came, so it is enough to count."""
    for given in (dut.i_start, dut.i):
        add_rules(m, given, Assume)
    add_rules(m, dut.o, Assert)
    followed = bench.choose(m, BITS, "followed")
    limit, begun = Signal.like(dut.limit), Signal()
    m.d.sync += [begun.eq(1), limit.eq(dut.limit)]
    with m.If(begun):
        m.d.comb += Assume(dut.limit == limit)
    with m.Else():
        m.d.comb += Assume(~dut.i.valid & ~dut.i_start.valid)
    m.d.comb += Assume(dut.limit <= COUNT)

    taken, passes, starts = transfers(dut.i), transfers(dut.o), transfers(dut.i_start)
    # Of the number followed: those that have been taken and have left, and whether one has passed.
    mine, mine_left, inside, passed = Signal(5), Signal(5), Signal(5), Signal()
    comes, goes, drops = (happens & (number == followed) for happens, number in (
        (taken, dut.i.payload), (passes, dut.o.payload), (dut.dropped, dut.number)))
    there = followed < dut.limit
    m.d.sync += [inside.eq(inside + taken - passes - dut.dropped), mine.eq(mine + comes - goes - drops),
                 mine_left.eq(mine_left + goes + drops), passed.eq(passed | goes)]
    with m.If(starts):
        m.d.sync += passed.eq(0)
        m.d.comb += Assert((inside == 0) & ~taken, "start")
    m.d.comb += [Assert(~(passes & dut.dropped), "one"), Assert(inside <= CAPACITY, "capacity")]
    with m.If(passes | dut.dropped):
        m.d.comb += Assert(inside != 0, "came")
    with m.If(goes | drops):
        m.d.comb += Assert(mine != 0, "came")
    with m.If(goes):
        m.d.comb += [Assert(~passed, "first"), Assert(there, "limit")]
    with m.If(drops):
        m.d.comb += [Assert(passed | ~there, "passes"), Assert(dut.wrong == ~there, "wrong")]
    m.d.comb += Cover(goes & (mine_left >= 2), "passes again in the second generation")


class Blind(UpdateMemory):
    """Does not look at the number just in front."""

    def _same_as(self, m, addresses, ahead, *, age):
        return Const(0) if ahead == 1 else super()._same_as(m, addresses, ahead, age=age)


class Sweepless(Generations):
    """Begins again without having emptied the memory."""

    def elaborate(self, platform):
        m = Module()
        m.d.comb += [self.i_start.ready.eq(1), self.generation.eq(1)]
        return m


def make(kind=Filter, generation_bits=1):
    narrow = type(kind.__name__, (kind,), {"capacity": CAPACITY})
    return Bench(once_per_generation, narrow(bits=BITS, count=COUNT, generation_bits=generation_bits, word_bits=WORD))


test_filter = declare(
    make, cycles=22, engine="abc bmc3", covers_nightly=True,
    # With tags of one bit each generation needs a sweep, with two bits the second one needs none.
    claims=[Claim(), Claim(generation_bits=2, nightly=True), Claim(cycles=28, nightly=True)],
    controls={
        "does not see the number in front": Control("first", kind=with_parts(Filter, UpdateMemory=Blind)),
        "begins while numbers are inside": Control("start", generation_bits=2, kind=source_fault(
            Filter, "self.i_start.ready.eq(generations.i_start.ready & (gate.level == 0))",
            "self.i_start.ready.eq(generations.i_start.ready)")),
        "empties nothing": Control("passes", kind=with_parts(Filter, Generations=Sweepless), nightly=True),
        "passes a number that does not exist": Control(
            "capacity", {"dropped": lambda dut: dut.dropped & ~dut.wrong}, nightly=True),
    })
