import re
from dataclasses import replace
from itertools import chain, pairwise, product, repeat

import cocotb
import numpy as np
import pytest
from amaranth.hdl import Elaboratable, Module, ResetInserter, Signal
from amaranth.lib import wiring
from amaranth.lib.wiring import In
from cocotb.triggers import ClockCycles, RisingEdge

from benchmarks.viewpoints import hard_records
from golden.cast.hemisphere import Hemisphere
from golden.engine.cast.naive_fixed import NaiveFixed
from golden.engine.ctu.sector import Sector
from golden.engine.icu.patch_setup import PatchSetup
from golden.engine.icu.patch_sums import section_sums
from golden.engine.icu.section_clip import section_clip
from golden.engine.icu.settle_code import settle_code
from golden.engine.icu.window_walk import window_tiles
from golden.scene.builtin import builtin_scene
from hw.icu.intersection_unit import TOKENS, IntersectionUnit, _product, _reaches, _successor_reaches
from radiosity.flow.package.example.frustum_load import frustum_payload, table_writes
from tb.golden.soups import soup
from tb.icu.unit_bench import section_hits, vertices
from tb.icu.unit_coverage import COVERAGE, CoveredBench
from tb.lib.clocking import start
from tb.lib.configurations import CONFIGURATIONS, config_of
from tb.lib.drawn import drawn
from tb.lib.no_x import assert_known
from tb.lib.parameter_ranges import corner
from tb.lib.runner import SIMULATORS, options, simulate
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.seed import NIGHTS, SEED
from tb.lib.simulator import simulator_of
from tb.lib.stall_patterns import STALL_PAIRS

# Small enough for short tests: a sweep of the ray memory has as many cycles as rays. Two bits of tags run out after
# three frusta of a bank.
SMALL = {"icu.rays": 1024, "icu.patch_bits": 10, "icu.side_bits": 8, "icu.generation_bits": 2}
FEW = {**SMALL, "icu.rays": 64, "icu.shadow_bits": 6}


def scene_of(name):
    return soup(int(name.removeprefix("soup "))) if name.startswith("soup ") else builtin_scene(name)


class Frusta:
    """A scene's hard frusta, cast one after the other."""

    def __init__(self, bench, *, scene, origins=1, rays=(64, 16), pixels=(32, 24), seed=1):
        self.bench, self.rays = bench, rays
        self.geometry, self.records = hard_records(scene_of(scene), origins=origins, rays=rays, pixels=pixels,
                                                   seed=seed, numbers=bench.config.numbers)
        self.naive = NaiveFixed(self.geometry, bench.config)
        self.pairs, self.inside = 0, 0

    async def check(self, record, order, section=None):
        """Hits of a frustum and their sums are golden's, field by field."""
        section = section or Sector.whole(record)
        weights = None if record.is_screen else Hemisphere(*self.rays).polar_weights
        await self.bench.begin(record, section, weights)
        await self.bench.cast(self.geometry, order)
        counters = self.bench.ports["counters"]
        self.pairs += counters["tested"]
        self.inside += counters["inside"]
        assert counters["won"] <= counters["inside"] <= counters["tested"] == counters["issued"] <= counters["visited"]
        await self.hits_of(record, section)
        if weights is not None:
            expected = section_hits(self.naive.cast(record), record, section)
            weight = np.broadcast_to(weights[:, None], (record.rows, record.columns))[
                section.first_row:section.end_row, section.first_column:section.end_column].ravel()
            sums = section_sums(expected.patch, weight)
            assert self.bench.sums == list(zip(sums.patch.tolist(), sums.sum.tolist(), strict=True))
        return counters

    def hits_among(self, record, order):
        """Golden's hits among some of the patches, by their ids in the scene."""
        hits = NaiveFixed(self.geometry[order], self.bench.config).cast(record)
        return replace(hits, patch=np.where(hits.patch >= 0, order[hits.patch], -1))

    async def hits_of(self, record, section):
        """The read-out of the present frustum."""
        expected = section_hits(self.naive.cast(record), record, section)
        hits = await self.bench.hits(section)
        different = hits.differences(expected)
        assert len(different) == 0, f"{len(different)} rays differ, the first is {different[0]}"


def frusta_options():
    """Smaller frusta for a slow simulator."""
    return {name: tuple(value) for name, value in options().items() if name in {"rays", "pixels"}}


def bench_of(dut, **stalls):
    given = options()
    return CoveredBench(dut, config_of(given["changes"], given["preset"]), **stalls)


@cocotb.test()
async def orders(dut):
    """Patches in the table's order and against it, so that of doubled ones either is first."""
    await start(dut, cycles=400_000)
    bench = bench_of(dut)
    await RisingEdge(dut.clk)
    assert_known(dut, [*bench.ports.sources, *bench.ports.sinks])
    for scene in options().get("scenes", ("cornell", "soup 3")):
        frusta = Frusta(bench, scene=scene, **frusta_options())
        ids = np.arange(len(frusta.geometry))
        for record in frusta.records:
            await frusta.check(record, ids)
            await frusta.check(record, ids[::-1])


@cocotb.test()
async def hard_patches(dut):
    """Many small soups with slivers, doubled and coplanar patches."""
    await start(dut, cycles=200_000 + 10 * options()["pairs"])
    bench = bench_of(dut)
    random = np.random.default_rng(options()["seed"])
    pairs = inside = 0
    seed = options()["seed"] * 1000
    while pairs < options()["pairs"]:
        seed += 1
        frusta = Frusta(bench, scene=f"soup {seed}", rays=(32, 16), pixels=(24, 18), seed=seed)
        for record in frusta.records:
            await frusta.check(record, random.permutation(len(frusta.geometry)))
        pairs += frusta.pairs
        inside += frusta.inside
    dut._log.info("%d pairs, %d of them inside", pairs, inside)
    assert inside > 0.02 * pairs, "too few of the pairs are hits"


@cocotb.test()
async def sections(dut):
    """Parts of a frustum, also such as windows go round."""
    await start(dut, cycles=200_000)
    bench = bench_of(dut)
    frusta = Frusta(bench, scene="soup 5", pixels=(60, 16))
    for record in frusta.records:
        for section in (Sector(0, record.columns, 3, 9), Sector(13, 50, 0, record.rows), Sector(7, 8, 5, 7)):
            await frusta.check(record, np.arange(len(frusta.geometry)), section)


@cocotb.test()
async def every_pair_of_stalls(dut):
    """Vertices come and tokens and hits are taken in every regime."""
    await start(dut, cycles=400_000)
    for number, (source, sink) in enumerate(STALL_PAIRS):
        if options().get("few_stalls") and number % 5 != (number // 5 + 1) % 5:
            continue
        bench = bench_of(dut, seed=number, i_vertex=source, o_done=sink, o_hit=sink)
        frusta = Frusta(bench, scene="soup 7", rays=(32, 8), pixels=(20, 15), seed=number)
        record = frusta.records[number % len(frusta.records)]
        await frusta.check(record, np.arange(len(frusta.geometry)))
        bench.ports.stop()


@cocotb.test()
async def reset_in_flight(dut):
    """A reset within a frustum leaves nothing behind."""
    await start(dut, cycles=200_000)
    for cut in options().get("cuts", (40, 150, 333)):
        bench = bench_of(dut)
        frusta = Frusta(bench, scene="soup 8", **frusta_options())
        record = frusta.records[0]
        await bench.begin(record, Sector.whole(record), Hemisphere(*frusta.rays).polar_weights)
        bench.ports.begin("i_vertex", vertices(frusta.geometry, np.arange(len(frusta.geometry))))
        await ClockCycles(dut.clk, cut)
        await bench.ports.reset()
        await frusta.check(frusta.records[1], np.arange(len(frusta.geometry)))
        await frusta.check(record, np.arange(len(frusta.geometry))[::-1])
        bench.ports.stop()


@cocotb.test()
async def read_out_beside_the_next_frustum(dut):
    """The other bank is read while the next frustum is cast, over more frusta than there are tags."""
    await start(dut, cycles=300_000)
    bench = bench_of(dut, seed=4, o_hit="random")
    frusta = Frusta(bench, scene="soup 9", origins=5)
    order = np.arange(len(frusta.geometry))
    reading = None
    for record in frusta.records:
        await bench.begin(record, Sector.whole(record))
        await bench.cast(frusta.geometry, order)
        if reading:
            await reading
        reading = cocotb.start_soon(frusta.hits_of(record, Sector.whole(record)))
        await ClockCycles(dut.clk, 20)
    await reading


@cocotb.test()
async def read_out_of_the_present_frustum(dut):
    """Patches that come meanwhile wait, the next frustum does not."""
    await start(dut, cycles=100_000)
    bench = bench_of(dut, o_hit="alternating")
    frusta = Frusta(bench, scene="soup 9")
    record, following = frusta.records[:2]
    order = np.arange(len(frusta.geometry))
    await bench.begin(record, Sector.whole(record))
    await bench.cast(frusta.geometry, order)
    again = cocotb.start_soon(bench.cast(frusta.geometry, order))
    await frusta.hits_of(record, Sector.whole(record))
    await again
    # After reset the first frustum of each bank waits for a sweep of the memory, which is longer than a read-out.
    for each in (following, record):
        await bench.begin(each, Sector.whole(each))
        await bench.cast(frusta.geometry, order)
    hits = bench.ports.sinks["o_hit"].items
    read = len(hits)
    reading = cocotb.start_soon(frusta.hits_of(record, Sector.whole(record)))
    await ClockCycles(dut.clk, 20)
    await bench.begin(following, Sector.whole(following))
    assert len(hits) - read < record.columns * record.rows, "the next frustum must begin during the read-out"
    await bench.cast(frusta.geometry, order)
    await reading
    await frusta.hits_of(following, Sector.whole(following))


@cocotb.test()
async def tables_and_the_next_frustum_wait_for_patches_in_flight(dut):
    """Tables of a screen wait, offered 0 to 3 cycles after a hemisphere's first vertex; so does its frustum, offered
    after the last vertex.
    """
    await start(dut, cycles=200_000)
    bench = bench_of(dut)
    frusta = Frusta(bench, scene="soup 9", rays=(32, 8), pixels=(20, 15))
    hemisphere = next(record for record in frusta.records if not record.is_screen)
    screen = next(record for record in frusta.records if record.is_screen)
    order = np.arange(len(frusta.geometry))
    taken = bench.ports.taken("i_vertex").items
    for after in range(4):
        taken.clear()
        await bench.begin(hemisphere, Sector.whole(hemisphere))
        cast = bench.ports.run(bench.cast(frusta.geometry, order))
        await bench.ports.until(lambda: taken)
        await ClockCycles(dut.clk, after)
        tables = bench.ports.begin("i_table", table_writes(screen, bench.config))
        await cast
        await frusta.hits_of(hemisphere, Sector.whole(hemisphere))
        await tables
        # The hemisphere is not read out; the frustum of the screen is offered after its last vertex.
        await bench.begin(hemisphere, Sector.whole(hemisphere))
        cast = bench.ports.run(bench.cast(frusta.geometry, order))
        await bench.ports.until(lambda: len(taken) == 8 * len(order))
        await ClockCycles(dut.clk, after)
        await bench.begin(screen, Sector.whole(screen))
        assert cast.done(), "the next frustum must wait for the last token"
        await bench.cast(frusta.geometry, order)
        await frusta.hits_of(screen, Sector.whole(screen))


@cocotb.test()
async def frusta_back_to_back(dut):
    """A large section directly behind a small one, over more frusta than there are tags."""
    await start(dut, cycles=200_000)
    bench = bench_of(dut)
    frusta = Frusta(bench, scene="soup 9", rays=(32, 8), pixels=(20, 15))
    record = frusta.records[0]
    whole, small = Sector.whole(record), Sector(7, 8, 5, 7)
    order = np.arange(len(frusta.geometry))
    for _ in range(2 << bench.config.icu.generation_bits):
        await bench.begin(record, whole)
        await bench.cast(frusta.geometry, order)
        await bench.ports.send("i_frustum", [frustum_payload(record, each, bench.config) for each in (small, whole)])
        # Hits left over from the previous frustum would be those of all patches.
        await bench.cast(frusta.geometry, order[::3])
        expected = section_hits(frusta.hits_among(record, order[::3]), record, whole)
        assert len((await bench.hits(whole)).differences(expected)) == 0


@cocotb.test()
async def read_out_at_the_first_vertex(dut):
    """A patch that begins about when a read-out is requested is in the hits, or waits until they have been read."""
    await start(dut, cycles=200_000)
    bench = bench_of(dut)
    frusta = Frusta(bench, scene="soup 9", rays=(32, 8), pixels=(20, 15))
    record = frusta.records[0]
    whole, count = Sector.whole(record), len(frusta.geometry)
    # The last patch is the one that most rays hit.
    patches = frusta.naive.cast(record).patch
    last = int(np.bincount(patches[patches >= 0]).argmax())
    before = np.setdiff1d(np.arange(count), [last])
    without = section_hits(frusta.hits_among(record, before), record, whole)
    included = []
    for after in range(-2, 6):
        await bench.begin(record, whole)
        await bench.cast(frusta.geometry, before)
        await ClockCycles(dut.clk, 20)
        tokens = len(bench.ports.sinks["o_done"].items)
        if after < 0:
            hits = bench.ports.run(bench.hits(whole))
            await ClockCycles(dut.clk, -after)
        cast = bench.ports.run(bench.cast(frusta.geometry, np.array([last])))
        if after >= 0:
            await ClockCycles(dut.clk, after)
            hits = bench.ports.run(bench.hits(whole))
        await bench.ports.until(lambda: len(bench.ports.sinks["o_hit"].items) % whole.rays)
        included.append(len(bench.ports.sinks["o_done"].items) > tokens)
        expected = section_hits(frusta.naive.cast(record), record, whole) if included[-1] else without
        assert len((await hits).differences(expected)) == 0, f"{after} cycles after the first vertex"
        await cast
        await frusta.hits_of(record, whole)
    dut._log.info("in the hits: %s", included)
    assert not included[0], "a patch that comes after the request must wait"
    assert included[-1], "a patch in flight must be waited for"


@cocotb.test()
async def rates(dut):
    """A quad every four cycles, and rays one per cycle where windows are large enough."""
    await start(dut, cycles=200_000)
    bench = bench_of(dut)
    config = bench.config
    frusta = Frusta(bench, scene="soup 4", rays=(64, 16))
    record = frusta.records[0]
    windows = section_clip(PatchSetup(record, config).patches(frusta.geometry).window, Sector.whole(record), record)
    # Many times the same small windows: vertices without a gap.
    small = np.resize(np.flatnonzero(window_tiles(windows, config.icu) <= 2), 200)
    taken = bench.ports.taken("i_vertex")
    await bench.begin(record, Sector.whole(record))
    await bench.cast(frusta.geometry, small)
    assert {b - a for a, b in pairwise(taken.cycles)} == {1}, "vertices must be taken without a gap"
    taken.stop()
    # The first of equal patches settles nothing: each of them tests all the rays of its window.
    rays = windows.rays
    large = np.resize(np.argsort(np.abs(rays - 64))[:3], 300)
    await bench.begin(record, Sector.whole(record))
    await bench.cast(frusta.geometry, large)
    counters = bench.ports["counters"]
    latency = 250
    busy = counters["tested"] / (counters["cycles"] - latency)
    dut._log.info("busy %.3f with %s", busy, counters)
    assert busy >= 0.97


@cocotb.test()
async def codes_are_floors(dut):
    """When all is done cell traversal reads of the settle map what each ray's best has."""
    await start(dut, cycles=100_000)
    bench = bench_of(dut)
    frusta = Frusta(bench, scene="cornell")
    record, config = frusta.records[0], bench.config
    await frusta.check(record, np.arange(len(frusta.geometry)))
    side = 1 << config.icu.tile_bits
    tiles = record.columns // side * (record.rows // side)
    bench.ports.begin("i_settle", range(tiles))
    words = await bench.ports.take("o_settle", tiles)
    codes = settle_code(frusta.naive.cast(record).inverse, config).reshape(record.rows, record.columns)
    for tile, word in enumerate(words):
        row, column = divmod(tile, record.columns // side)
        for lane, code in enumerate(word):
            assert code == codes[row * side + lane // side, column * side + lane % side]


@cocotb.test()
async def windows_of_one_ray(dut):
    """One after the other on the same ray, nearer and farther ones mixed: updates in consecutive cycles."""
    await start(dut, cycles=100_000)
    bench = bench_of(dut)
    frusta = Frusta(bench, scene="soup 3")
    for record in frusta.records:
        windows = section_clip(PatchSetup(record, bench.config).patches(frusta.geometry).window, Sector.whole(record),
                               record)
        single = np.flatnonzero(windows.rays == 1)
        await frusta.check(record, np.concatenate([np.repeat(single, 6), np.arange(len(frusta.geometry))]))


@cocotb.test()
async def back_pressure_reaches_the_vertices(dut):
    """While no token is taken, tokens, windows and slots fill up, and then vertices wait; nothing is lost."""
    await start(dut, cycles=100_000)
    held = [True]
    bench = bench_of(dut, o_done=iter(lambda: held[0], None))
    slots = bench.config.icu.slots
    frusta = Frusta(bench, scene="soup 4")
    record, count = frusta.records[0], len(frusta.geometry)
    windows = section_clip(PatchSetup(record, bench.config).patches(frusta.geometry).window, Sector.whole(record),
                           record)
    small = np.resize(np.flatnonzero(window_tiles(windows, bench.config.icu) <= 2), 2 * (TOKENS + slots))
    await bench.begin(record, Sector.whole(record))
    taken = bench.ports.taken("i_vertex")
    cast = cocotb.start_soon(bench.cast(frusta.geometry, np.concatenate([np.arange(count), small])))
    before = -1
    while before < len(taken.items):
        before = len(taken.items)
        # Longer than any window.
        await ClockCycles(dut.clk, 1200)
    assert not cast.done()
    assert before // 4 >= TOKENS + slots, "as many patches must come as there are free slots"
    COVERAGE.hit_all({"tokens wait": bool(int(dut.o_done__valid.value)),
                      "as many patches in flight as slots": before // 4 >= slots})
    held[0] = False
    await cast
    await frusta.hits_of(record, Sector.whole(record))


@cocotb.test()
async def whole_frusta(dut):
    """Frusta of a large scene in both orders, and how busy the rays keep the pipeline."""
    given = options()
    await start(dut, cycles=given["cycles"])
    bench = bench_of(dut)
    random = np.random.default_rng(given["seed"])
    frusta = Frusta(bench, scene=given["scene"], rays=tuple(given["rays"]), pixels=tuple(given["pixels"]))
    for record in frusta.records:
        for order in (np.arange(len(frusta.geometry)), random.permutation(len(frusta.geometry))):
            counters = await frusta.check(record, order)
            busy = counters["tested"] / counters["cycles"]
            dut._log.info("%s: busy %.3f, %s", given["scene"], busy, counters)
            assert busy >= given["busy"], f"a ray is tested in {busy:.3f} of all cycles"


@cocotb.test()
async def every_case_occurred(dut):
    """The frusta of the coroutines before had all that there is to be tried."""
    await start(dut, cycles=100)
    dut._log.info("%s", COVERAGE.counts)
    COVERAGE.check()


# Each is built for itself, which takes longer than its run.
OTHERS = {"narrow": CONFIGURATIONS["narrow"], "1 register": {"icu.product_registers": 1},
          "3 registers": {"icu.product_registers": 3}, "small tiles": {"icu.tile_bits": 1},
          "large tiles": {"icu.tile_bits": 3}, "no u and v": {"icu.uv_bits": 0}, "few slots": {"icu.slots": 16}}
QUICK = ("orders", "hard_patches", "sections", "every_pair_of_stalls", "reset_in_flight",
         "read_out_beside_the_next_frustum", "read_out_of_the_present_frustum",
         "tables_and_the_next_frustum_wait_for_patches_in_flight", "frusta_back_to_back",
         "read_out_at_the_first_vertex", "rates", "codes_are_floors",
         "windows_of_one_ray", "back_pressure_reaches_the_vertices", "every_case_occurred")


def run(name, tests, *, simulator="verilator", changes=None, preset="tiny", **given):
    changes = {**SMALL, **(changes or {})}
    component = IntersectionUnit(config=config_of(changes, preset))
    simulate(component, __name__, tests, simulator=simulator, name=name, changes=changes,
             preset=preset, **given)


@pytest.mark.sim
def test_the_unit_in_verilator():
    """Each pattern of stalls once at either end; the nightly has all pairs."""
    run("unit", QUICK, pairs=1_000, few_stalls=True)


@pytest.mark.nightly
def test_all_pairs_of_stalls():
    run("unit-stalls", ("every_pair_of_stalls",))


@pytest.mark.nightly
def test_many_hard_patches():
    run("unit-hard", ("hard_patches",), pairs=50_000 * NIGHTS)


@pytest.mark.nightly
@pytest.mark.parametrize("simulator", SIMULATORS[1:])
def test_the_unit_in_icarus(simulator):
    run("unit-icarus", ("orders", "reset_in_flight"), simulator=simulator, changes=FEW, scenes=["soup 3"], cuts=[150],
        rays=(16, 4), pixels=(8, 8))


@pytest.mark.nightly
@pytest.mark.parametrize("what", drawn([*OTHERS], 3))
def test_other_widths_and_depths(what):
    run(what, ("orders", "every_pair_of_stalls"), changes=OTHERS[what], few_stalls=True)


@pytest.mark.nightly
@pytest.mark.parametrize("scene", drawn(["cornell", "lobby", "room1627"]))
def test_whole_frusta(scene):
    run(f"unit-{scene}", ("whole_frusta",), scene=scene, busy=0.9, rays=(256, 64), pixels=(120, 90), preset="small",
        changes={"icu.rays": 1 << 14, "icu.patch_bits": 11, "icu.generation_bits": 4}, cycles=3_000_000)


def test_tiles_of_a_section_are_rounded_up_to_a_power_of_two():
    bits, m = 7, Module()
    # Powers of two and the numbers beside them.
    counts = sorted({min(64, max(1, (1 << power) + beside)) for power in range(7) for beside in (-1, 0, 1)})
    across, down, tiles = Signal(bits), Signal(bits), Signal(bits)
    m.d.comb += tiles.eq(_product(_reaches(across, bits), _successor_reaches(down, bits)))

    def rounded(number):
        return 1 << (number - 1).bit_length()

    async def check(ctx):
        for columns, rows in product(counts, repeat=2):
            ctx.set(across, columns)
            ctx.set(down, rows - 1)
            await ctx.delay(1e-9)
            expected = min(rounded(columns) * rounded(rows), 1 << bits - 1)
            assert ctx.get(tiles) == expected, f"{columns} x {rows} tiles"

    simulator_of(m, check, period=None).run()


class _WithReset(Elaboratable):
    """A component with the reset that its cluster has."""

    def __init__(self, component):
        self._component, self.reset = component, Signal()
        for name in component.signature.members:
            setattr(self, name, getattr(component, name))
        self.signature = wiring.Signature({**component.signature.members, "reset": In(1)})

    def elaborate(self, platform):
        return ResetInserter(self.reset)(self._component)


def begun(bench, rays, before=(), resets=None):
    """The cycles in which rays and frustum are accepted. With ``rays`` it is a shadow frustum; after as many rays as
    ``before`` has, and their cycles, the unit is reset in the cycle ``resets``, and the list begins again.
    """
    listed = [(0, {"ray": ray, "end": 1, "is_ray": 1, "last": int(ray == rays - 1)}) for ray in range(rays)]
    again = [(resets - before[-1] + 1, listed[0][1]), *listed[1:]] if before else listed
    bench.run(Schedule(items={
        "i_frustum": [(FEW["icu.rays"] + 20, {
            "section": {"end_column": 8, "end_row": 8}, "tiles_across": 2, "is_shadow": int(rays > 0)})],
        "i_ray": listed[:len(before)] + again}),
        reset=chain(repeat(0, resets - 1), [1], repeat(0)) if before else 0)
    return bench.cycles["i_ray"], bench.cycles["i_frustum"]


@pytest.fixture(scope="module")
def begin_bench():
    return ScheduleBench(_WithReset(IntersectionUnit(config=config_of(FEW))), ["i_frustum", "i_ray"], [],
                         idle_limit=FEW["icu.rays"] + 20)


@pytest.mark.sim
@pytest.mark.parametrize(("rays", "timing"), [
    (0, r"accepted ``(\d+)`` cycles after it is offered"),
    (3, r"a shadow frustum ``(\d+)`` cycles after the last of its rays")])
def test_a_frustum_is_accepted_as_soon_as_documented(begin_bench, rays, timing):
    """Where nothing is in flight, and the rows that it uses have been swept; with ``rays`` it is a shadow frustum."""
    listed, accepted = begun(begin_bench, rays)
    first = listed[-1] if rays else begin_bench.trace.offered["i_frustum"][0]
    assert accepted == [first + int(re.search(timing, IntersectionUnit.__doc__)[1])]


@pytest.mark.sim
def test_a_reset_leaves_nothing_of_a_list(begin_bench):
    """Between its rays, and until its frustum begins: the list that comes then takes as long as any."""
    whole, (accepted,) = begun(begin_bench, 3)
    for resets in whole[1], (whole[-1] + accepted) // 2, accepted - 1:
        listed, again = begun(begin_bench, 3, [cycle for cycle in whole if cycle < resets], resets)
        assert again == [listed[-1] + accepted - whole[-1]], f"reset in cycle {resets}"


@pytest.mark.parametrize("number", range(4))
def test_there_is_a_unit_at_all_ends_of_the_parameters_ranges(number):
    """Of two branches that join the same one is the earlier in all of them."""
    unit = IntersectionUnit(config=corner(np.random.default_rng([SEED, number]), "numbers.", "icu."))
    assert min(unit._setup._waits.values()) > 0
