"""The tags of the settle map: a code that is read is never too large, and none is lost, whatever was cast before."""

from amaranth.hdl import Array, Assert, Assume, Cat, Cover, Mux, Signal

from golden.engine.config import PRESETS
from hw.icu.icu_tables import scale
from hw.icu.settle_map import SettleMap
from hw.lib.generations import Generations
from tb.formal.bench import Bench, transfers
from tb.formal.declare import Control, declare
from tb.formal.source_fault import source_fault, with_parts
from tb.formal.stream_rules import add_rules

# Tags of one bit: each frustum needs a sweep.
CONFIG = PRESETS["tiny"].replace({"icu.rays": 64, "icu.side_bits": 6, "icu.slots": 16, "icu.settle_bits": 4,
                                  "icu.settle_fraction": 2, "icu.tile_bits": 1, "icu.generation_bits": 1})
LANES = 1 << 2 * CONFIG.icu.tile_bits
# Tiles of a frustum: a sweep over all would take too many cycles.
TILES = 2
# Cycles from a write until it can be read, and from a read of the window walk, and of cell traversal, to its word.
VISIBLE, WALK, SURVIVAL = 6, 3, 4
# Cycles from the beginning of a frustum to its first read.
WAIT = 4


def codes_of_the_frustum(m, bench, dut, wait):
    """What is read of one ray, any ray, is the code of a write of this frustum, at least of that `VISIBLE` cycles ago;
    or 0 while it is being written.

    A frustum begins when no write is in flight, and its codes never fall. Reads come at least ``wait`` cycles
    after its beginning.
    """
    ray = bench.choose(m, range(TILES * LANES), "ray")
    add_rules(m, dut.i_start, Assume)
    m.d.comb += Assume(dut.tiles == TILES)
    (first, cut), starts, given = scale(CONFIG), transfers(dut.i_start), dut.i.payload
    scaled, code, latest = (given.inverse - first) >> cut, Signal(CONFIG.icu.settle_bits), Signal(
        CONFIG.icu.settle_bits)
    mine, quiet, begun = dut.i.valid & (given.ray == ray), Signal(range(VISIBLE + 1), init=VISIBLE), Signal()
    m.d.comb += [code.eq(Mux(scaled < 0, 0, Mux(scaled > CONFIG.icu.settle.high, CONFIG.icu.settle.high, scaled))),
                 Assume(given.ray < TILES * LANES), Assume(~mine | (code >= latest)), Assume(dut.o_read.ready),
                 Assume(~dut.i.valid | (begun & ~dut.i_start.valid)), Assume(~dut.i_start.valid | (quiet == VISIBLE))]
    m.d.sync += [begun.eq(begun | starts), quiet.eq(Mux(dut.i.valid, 0, quiet + (quiet != VISIBLE)))]
    age = Signal(range(wait + 1))
    m.d.sync += age.eq(Mux(starts, 1, age + (begun & (age != wait))))
    # The latest code, and what it was in earlier cycles of the frustum.
    history = Array(Signal.like(latest, name=f"latest_{k}") for k in range(VISIBLE + SURVIVAL + 1))
    came = Signal(len(history) - 1)
    m.d.sync += came.eq(Cat(mine, came))
    m.d.comb += [latest.eq(history[0])]
    with m.If(starts):
        m.d.sync += [one.eq(0) for one in history]
    with m.Else():
        m.d.sync += [later.eq(one) for one, later in zip(history, list(history)[1:], strict=False)]
        with m.If(mine):
            m.d.sync += history[0].eq(code)
    frusta, some = Signal(2), Signal()
    m.d.sync += frusta.eq(frusta + (starts & (frusta != 3)))
    with m.If(mine & (frusta == 1) & (code != 0)):
        m.d.sync += some.eq(1)
    for name, read, tile, word, latency in (
            ("walk", dut.i_walk.valid, dut.i_walk.payload.tile, dut.o_walk.payload.word, WALK),
            ("survival", transfers(dut.i_read), dut.i_read.payload, dut.o_read.payload, SURVIVAL)):
        requested = read & (tile == ray // LANES) & (age == wait) & ~starts
        for number in range(latency):
            later = Signal(name=f"{name}_{number}")
            m.d.sync += later.eq(requested & ~starts)
            requested = later
        found = Array(word)[ray % LANES]
        with m.If(requested):
            is_written = came[latency + VISIBLE - 2]
            m.d.comb += [Assert(found <= Mux(is_written, 0, history[latency - 1]), "too large"),
                         Assert(is_written | (found >= history[latency + VISIBLE - 1]), "lost")]
        m.d.comb += [Cover(requested & (frusta == 2) & some & (found != 0), f"{name}: a code of the second frustum"),
                     Cover(requested & (frusta == 2) & some & (history[0] == 0),
                           f"{name}: none, after one of the first")]


class Sweepless(Generations):
    """Begins again without having emptied the memory."""

    def elaborate(self, platform):
        m = super().elaborate(platform)
        m.d.comb += [self.sweeps.eq(0), self.i_start.ready.eq(1)]
        return m


def make(kind=SettleMap, generations=Generations, wait=WAIT):
    return Bench(codes_of_the_frustum, with_parts(kind, Generations=generations)(config=CONFIG, tag=1), wait=wait)


def faulty(right, wrong):
    return source_fault(SettleMap, right, wrong)


test_settle_map = declare(
    make, cycles=26, engine="abc bmc3", covers_nightly=True, controls={
        "a tag is not compared": Control("too large", kind=faulty("(tag == generations.generation)", "(tag == tag)")),
        "other rays of a word keep their codes": Control(
            "too large", kind=faulty("(mine | made.written)", "mine"), nightly=True),
        "other rays of a word lose their codes": Control(
            "lost", kind=faulty("(mine | made.written)", "1"), nightly=True),
        "nothing is emptied": Control(
            "too large", generations=Sweepless, nightly=True),
        "what is being written is used": Control(
            "too large", kind=faulty(" & ~(were_written & met_write.replicate(lanes))", ""), nightly=True),
        "a read comes too early": Control("too large", wait=WAIT - 1, nightly=True),
    })
