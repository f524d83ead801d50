"""The tags of the ray memory: nothing of an earlier frustum is ever seen, whatever was cast in either bank."""

from amaranth.hdl import Array, Assert, Assume, Cat, Cover, Signal

from golden.engine.config import PRESETS
from hw.icu.ray_memory import BANKS, RayMemory
from hw.lib.generations import Generations
from tb.formal.bench import Bench, transfers
from tb.formal.declare import Claim, Control, declare
from tb.formal.source_fault import source_fault, with_parts
from tb.formal.stream_rules import add_rules

# Tags of one bit: each frustum of a bank needs a sweep.
CONFIG = PRESETS["tiny"].replace({"icu.rays": 64, "icu.side_bits": 6, "icu.slots": 16, "icu.settle_bits": 4,
                                  "icu.settle_fraction": 2, "icu.patch_bits": 8, "icu.generation_bits": 1})
# Rays of a frustum: a sweep over all would take too many cycles.
RAYS = 2
LATENCY = 5


def nearest_of_its_frustum(m, bench, dut):
    """An update of one ray, any ray, wins exactly if the ray had no nearer hit since its frustum began.

    A frustum begins when no update is in flight.
    """
    ray = bench.choose(m, range(RAYS), "ray")
    add_rules(m, dut.i_start, Assume)
    m.d.comb += Assume(dut.rays == RAYS)
    given, got, starts = dut.i.payload, dut.o.payload, transfers(dut.i_start)
    began, inside = Signal(), Signal(4)
    m.d.sync += [began.eq(began | starts), inside.eq(inside + dut.i.valid - dut.o.valid)]
    m.d.comb += [Assume(given.ray < RAYS), Assume(~dut.i_read.valid), Assume(~dut.i_payload.valid),
                 Assume(~dut.i.valid | (began & ~dut.i_start.valid)), Assume(~dut.i_start.valid | (inside == 0))]

    # The best of each bank since its frustum began, one update after the other, each at once.
    key, mine = Cat(~given.patch, given.inverse), dut.i.valid & (given.ray == ray)
    best = Array(Signal(len(key), name=f"best_{bank}") for bank in range(BANKS))
    some = Array(Signal(name=f"some_{bank}") for bank in range(BANKS))
    wins = Signal()
    m.d.comb += wins.eq(given.hit & (~some[dut.active] | (key > best[dut.active])))
    with m.If(mine & wins):
        m.d.sync += [best[dut.active].eq(key), some[dut.active].eq(1)]
    with m.If(starts):
        # The other bank begins.
        m.d.sync += some[~dut.active].eq(0)
    expected = Cat(mine, wins)
    for age in range(LATENCY):
        later = Signal(2, name=f"expected_{age}")
        m.d.sync += later.eq(expected)
        expected = later
    with m.If(expected[0]):
        m.d.comb += [Assert(dut.o.valid & (got.ray == ray), "latency"), Assert(got.won == expected[1], "won")]
    # A bank's second frustum, with a hit that is farther than one of the first.
    frusta, high = Signal(2), Signal()
    m.d.sync += frusta.eq(frusta + (starts & (frusta != 3)))
    with m.If(mine & wins & (frusta == 1)):
        m.d.sync += high.eq(given.inverse[-1])
    m.d.comb += [Cover(expected[0] & expected[1] & (frusta == 3) & high,
                       "wins in the second frustum of a bank"),
                 Cover(expected[0] & ~expected[1] & (frusta == 3), "loses in the second frustum of a bank")]


class Sweepless(Generations):
    """Begins again without having emptied the memory."""

    def elaborate(self, platform):
        m = super().elaborate(platform)
        m.d.comb += [self.sweeps.eq(0), self.i_start.ready.eq(1)]
        return m


def make(kind=RayMemory, generations=Generations):
    return Bench(nearest_of_its_frustum, with_parts(kind, Generations=generations)(config=CONFIG, tag=1))


test_ray_memory = declare(
    make, cycles=24, engine="abc bmc3", covers_nightly=True, claims=[Claim()],
    controls={
        "a tag is not compared": Control("won", kind=source_fault(
            RayMemory, "is_new, is_larger = old.generation != operand.row.generation, new_key > old_key",
            "is_new, is_larger = Const(0), new_key > old_key"), nightly=True),
        "nothing is emptied": Control(
            "won", generations=Sweepless, nightly=True),
        "equal hits of the larger id win": Control("won", kind=source_fault(
            RayMemory, "given.operand.row.complement.eq(~self.i.payload.patch)",
            "given.operand.row.complement.eq(self.i.payload.patch)"), nightly=True),
    })
