"""Survival by squares swept from the settle map: golden's decisions, and "live" while codes are old."""

from itertools import pairwise

import numpy as np
import pytest
from amaranth.lib.data import StructLayout

from golden.engine.ctu.sector import Sector
from golden.engine.ctu.settle_pyramid import SettlePyramid
from golden.engine.ctu.survival import survivors_by_code
from golden.engine.stimulus.ctu.grids import shells
from golden.engine.stimulus.frusta import random_hemisphere, random_screen
from hw.ctu.ctu_formats import GRID_GROUP, CtuFormats
from hw.ctu.survival import Survival
from radiosity.flow.package.example.frustum_load import frustum_payload, tiles
from radiosity.flow.package.example.grid_load import GridAddresses, grid_writes, grouped
from tb.lib.configurations import config_of
from tb.lib.coverage import Coverage
from tb.lib.simulator import simulator_of
from tb.lib.stall_patterns import STALLS
from tb.lib.timing import documented_latency

RAYS, SHELLS = 240, (2, 3, 5, 8)


class Case:
    """A section of a frustum, its settle codes, and grid rays of some shells."""

    def __init__(self, config, seed, *, screen, whole, rays=RAYS):
        self.config, self.random = config, np.random.default_rng(seed)
        random = self.random
        self.record = record = (random_screen if screen else random_hemisphere)(random, config)
        first = random.integers([record.columns // 2, record.rows // 2]).tolist()
        end = random.integers(np.array(first) + 1, [record.columns, record.rows], endpoint=True).tolist()
        self.section = Sector.whole(record) if whole else Sector(first[0], end[0], first[1], end[1])
        self.grids = [shells(record)(shell) for shell in SHELLS]
        self.thresholds = {grid.shell: int(threshold) for grid, threshold in zip(
            self.grids, random.permutation([60, 110, 200, 256]), strict=True)}
        self.write(self.draw())
        addresses = GridAddresses(self.grids)
        requested = [(grid, number) for grid in self.grids for number in range(grid.rows * grid.columns)]
        # Neighbours, and rays alone.
        chosen = np.zeros(len(requested), dtype=bool)
        while chosen.sum() < min(rays, 7 * len(requested) // 8):
            first = random.integers(len(requested))
            chosen[first:first + random.choice([1, 1, 3, GRID_GROUP, 20])] = True
        self.requested = {addresses.request(*requested[k])["ray"]: requested[k] for k in np.flatnonzero(chosen)}
        self.items = [{"first": {name: group[name] for name in ("ray", "shell", "row", "column")},
                       "count": group["count"]} for group in grouped(addresses.request(*one)
                                                                     for one in self.requested.values())]

    def draw(self):
        """High codes, and some low ones near each other."""
        random, section = self.random, self.section
        shape = section.end_row - section.first_row, section.end_column - section.first_column
        codes = random.integers(100, 256, size=shape)
        for row, column in zip(*(random.integers(count, size=2) for count in shape), strict=True):
            codes[row:row + 5, column:column + 5] = random.integers(256)
        return codes

    def expected(self):
        """Whether each of the grid rays goes on, by its number."""
        pyramid = SettlePyramid(self.codes, self.config)
        going = {grid.shell: survivors_by_code(grid, pyramid, self.thresholds[grid.shell], self.section,
                                               self.record).ravel() for grid in self.grids}
        return {ray: bool(going[grid.shell][number]) for ray, (grid, number) in self.requested.items()}

    def write(self, codes):
        """Into the settle map: what lies beyond the section's border is never written."""
        self.codes = codes
        side, (across, down) = 1 << self.config.icu.tile_bits, tiles(self.section, self.config)
        whole = np.zeros((down * side, across * side), dtype=np.int64)
        whole[:self.codes.shape[0], :self.codes.shape[1]] = self.codes
        self.words = whole.reshape(down, side, across, side).transpose(0, 2, 1, 3).reshape(down * across, -1).tolist()


def rays_of(group):
    """The numbers of its rays."""
    return range(group["first"]["ray"], group["first"]["ray"] + group["count"])


class SurvivalBench:
    """Survival in Amaranth's simulator, with a settle map."""

    def __init__(self, case, *, source="none", sink="none", stall=0.0):
        formats = CtuFormats(case.config)
        self.case, self.dut = case, Survival(config=case.config, ray=StructLayout({
            "ray": formats.grid_number, "shell": formats.shell, "row": formats.grid_row_address,
            "column": formats.grid_column_address}))
        self._stalls, self._stops, self._stall = STALLS[source](1), STALLS[sink](2), stall
        self.lived, self.dropped, self.taken = {}, {}, {}
        self._cycle, self.sweeps, self.ready, self.holds, self.held = 0, 0, True, False, 0

    def run(self, test):
        """Until the testbench is over."""
        async def testbench(ctx):
            await self._begin(ctx)
            await test(ctx, self)

        simulator = simulator_of(self.dut)
        for process in testbench, self._settle, self._take, self._watch:
            simulator.add_testbench(process, background=process is not testbench)
        simulator.run()

    async def _begin(self, ctx):
        case, dut = self.case, self.dut
        ctx.set(dut.frustum, frustum_payload(case.record, case.section, case.config))
        for write in grid_writes(case.grids, case.config, thresholds=case.thresholds):
            ctx.set(dut.i_table.valid, 1)
            ctx.set(dut.i_table.payload, write)
            await ctx.tick()
        ctx.set(dut.i_table.valid, 0)
        await self.start(ctx)

    async def start(self, ctx):
        """A frustum."""
        ctx.set(self.dut.i_start.valid, 1)
        await ctx.tick().until(self.dut.i_start.ready)
        ctx.set(self.dut.i_start.valid, 0)
        self.sweeps = 0

    async def swept(self, ctx):
        """Until all squares are of the present codes."""
        until = self.sweeps + 3
        while self.sweeps < until:
            await ctx.tick()
        await ctx.tick().repeat(60)

    async def send(self, ctx, items):
        """Groups, until all of their rays are decided; which of them go on, by number."""
        self.lived, self.dropped, self.taken = {}, {}, {}
        for item in items:
            while next(self._stalls):
                ctx.set(self.dut.i.valid, 0)
                await ctx.tick()
            ctx.set(self.dut.i.payload, item)
            ctx.set(self.dut.i.valid, 1)
            await ctx.tick().until(self.dut.i.ready)
        ctx.set(self.dut.i.valid, 0)
        waited = 0
        while len(self.lived) + len(self.dropped) < sum(item["count"] for item in items):
            await ctx.tick()
            waited += 1
            assert waited < 20_000, "the bench hangs"
        return {ray: ray in self.lived for item in items for ray in rays_of(item)}

    async def _take(self, ctx):
        """Who goes on and who does not, and when; ``ready`` comes and goes."""
        dut = self.dut
        drops = [getattr(dut, f"o_dropped_{level}") for level in range(self.case.config.ctu.pyramid_levels)]
        signals = [dut.i.valid & dut.i.ready, dut.i.payload, dut.o.valid, dut.o.payload,
                   *(signal for one in drops for signal in (one.valid, one.payload))]
        while True:
            ready = not next(self._stops)
            ctx.set(dut.o.ready, ready)
            _, _, takes, taken, valid, lives, *dropped = await ctx.tick().sample(*signals)
            self._cycle += 1
            if takes:
                self.taken.update(dict.fromkeys(rays_of(taken), self._cycle))
            if valid and ready:
                assert lives["ray"] not in self.lived, "a grid ray goes on once"
                self.lived[lives["ray"]] = self._cycle
            for valid, group in zip(dropped[::2], dropped[1::2], strict=True):
                if valid:
                    assert not self.dropped.keys() & set(rays_of(group)), "a grid ray is dropped once"
                    self.dropped.update(dict.fromkeys(rays_of(group), self._cycle))
            assert not set(self.lived) & set(self.dropped)

    async def _watch(self, ctx):
        """What is offered to the scan of the tiles stays until it is accepted."""
        offer, held = self.dut._scans[0].i, None
        while True:
            *_, valid, ready, payload = await ctx.tick().sample(offer.valid, offer.ready, offer.payload.as_value())
            assert held is None or (valid and payload == held), "an offer changed or was withdrawn"
            held = payload if valid and not ready else None
            self.held += held is not None

    async def _settle(self, ctx):
        """The settle map's words, some cycles late."""
        dut, waiting, offers = self.dut, [], False
        ctx.set(dut.o_tile.ready, 1)
        while True:
            *_, requests, tile, taken = await ctx.tick().sample(dut.o_tile.valid, dut.o_tile.payload, dut.i_word.ready)
            waiting = [(left - 1, word) for left, word in waiting]
            if offers and taken:
                waiting.pop(0)
                offers = False
            if requests and self.ready:
                self.sweeps += tile == 0
                waiting.append((4, self.case.words[tile]))
            offers = bool(waiting) and waiting[0][0] <= 0 and (
                offers or (not self.holds and self.case.random.random() >= self._stall))
            ctx.set(dut.i_word.valid, int(offers))
            if offers:
                ctx.set(dut.i_word.payload, waiting[0][1])
            self.ready = len(waiting) < 8
            ctx.set(dut.o_tile.ready, int(self.ready))


# Sections of the whole frustum and of a part of it, all depths of the pyramid, small tiles, and stalls.
CASES = [
    ({"ctu.pyramid_levels": 2}, 11, {"screen": False, "whole": True},
     {"source": "random", "sink": "bursts"}),
    pytest.param({"ctu.pyramid_levels": 1}, 12, {"screen": True, "whole": True}, {}, marks=pytest.mark.sim),
    pytest.param({"ctu.pyramid_levels": 3, "icu.tile_bits": 1}, 13, {"screen": False, "whole": False},
                 {"source": "bursts", "sink": "random", "stall": 0.4}, marks=pytest.mark.nightly),
]


@pytest.mark.parametrize(("changes", "seed", "kind", "stalls"), CASES)
def test_decisions_of_golden(changes, seed, kind, stalls):
    config = config_of(changes)
    case = Case(config, seed, **kind)
    # A screen's grid rays are few: each stands for many rays.
    parts = [] if kind["screen"] else ["some of a group go on"]
    coverage = Coverage(["goes on", "does not", "lives while codes are unknown", "dies when codes have grown",
                         "begins live again", *parts])

    async def test(ctx, bench):
        # Until the first sweep is over every grid ray with rays of the section near it goes on.
        first = case.expected()
        bench.holds = True
        early = await bench.send(ctx, case.items[::8])
        assert all(came or not first[ray] for ray, came in early.items())
        coverage.hit("lives while codes are unknown", [came and not first[ray] for ray, came in early.items()])
        bench.holds = False
        await bench.swept(ctx)
        assert await bench.send(ctx, case.items) == first
        # Codes grow; until the next sweep has found them, more go on.
        case.write(np.maximum(case.codes, case.random.integers(120, 256, size=case.codes.shape)))
        grown = case.expected()
        meanwhile = await bench.send(ctx, case.items[::8])
        assert all(came or not grown[ray] for ray, came in meanwhile.items())
        await bench.swept(ctx)
        assert await bench.send(ctx, case.items) == grown
        coverage.hit_all({
            "goes on": list(first.values()), "does not": [not one for one in first.values()],
            "dies when codes have grown": [first[ray] and not grown[ray] for ray in first],
            **{part: [len({first[ray] for ray in rays_of(item)}) == 2 for item in case.items] for part in parts}})
        # A new frustum: all codes are 0 until they have been read again.
        await bench.start(ctx)
        bench.holds = True
        again = await bench.send(ctx, case.items[::8])
        coverage.hit("begins live again", [came and not grown[ray] for ray, came in again.items()])

    bench = SurvivalBench(case, **stalls)
    bench.run(test)
    coverage.check()
    assert bench.held, "the scan of the tiles must stall"


@pytest.mark.sim
def test_a_high_section_of_one_word_across_behind_a_wide_one():
    """Words are of 8 x 8 rays; the section has as many as the memory, and each counts by itself."""
    config = config_of({"ctu.pyramid_levels": 1, "icu.tile_bits": 1, "icu.rays": 256})
    case, found = Case(config, 11, screen=True, whole=True), []

    async def test(ctx, bench):
        for section in Sector(0, 60, 0, 4), Sector(0, 8, 0, 32):
            case.section = section
            ctx.set(bench.dut.frustum, frustum_payload(case.record, section, config))
            await bench.start(ctx)
            for row in range(0, section.end_row, 8):
                codes = np.full((section.end_row, section.end_column), 255)
                codes[row:row + 8] = 0
                case.write(codes)
                await bench.swept(ctx)
                found.append(case.expected())
                assert await bench.send(ctx, case.items) == found[-1]

    SurvivalBench(case).run(test)
    differ = [any(one[ray] != other[ray] for ray in one) for one, other in pairwise(found[1:])]
    assert len(differ) == 3
    assert all(differ)


@pytest.mark.sim
def test_what_lies_behind_column_0():
    """Of a window that goes round all squares count, whichever of its rows they are in, and no others.

    Words are of 8 x 8 rays: a window has several rows of them.
    """
    case = Case(config_of({"ctu.pyramid_levels": 2, "icu.tile_bits": 1}), 11, screen=False, whole=True)
    columns, rows = case.record.columns, case.record.rows
    firsts = {ray: int(grid.first_column.ravel()[number]) for ray, (grid, number) in case.requested.items()}
    coverage = Coverage(["goes on by what lies behind column 0"])

    async def test(ctx, bench):
        for row in range(0, rows, rows // 4):
            codes = np.full((rows, columns), 255)
            codes[row, 0] = 0
            case.write(codes)
            await bench.swept(ctx)
            expected = case.expected()
            assert await bench.send(ctx, case.items) == expected
            coverage.hit("goes on by what lies behind column 0", [
                one and case.thresholds[case.requested[ray][0].shell] < 256 and firsts[ray] > columns // 2
                for ray, one in expected.items()])

    SurvivalBench(case).run(test)
    coverage.check()


@pytest.mark.parametrize("levels", [2, *(pytest.param(other, marks=pytest.mark.nightly) for other in (1, 3))])
def test_rates_after_the_latency(levels):
    """A group per cycle, or a ray of a live group; and after the latency a ray alone."""
    config = config_of({"ctu.pyramid_levels": levels})
    # A small section, of which no window has more than a word of squares.
    case = Case(config, 21, screen=True, whole=False, rays=200)
    case.section = Sector(0, min(16, case.record.columns), 0, min(16, case.record.rows))
    size = case.section.end_row, case.section.end_column
    # Of shells in which a ray can settle.
    full = [item for item in case.items if item["count"] == GRID_GROUP
            and case.thresholds[item["first"]["shell"]] < 256]
    assert len(full) > 8

    async def test(ctx, bench):
        case.write(np.zeros(size, dtype=np.int64))
        await bench.swept(ctx)
        await bench.send(ctx, [{**item, "count": 1} for item in case.items[:1]])
        assert {bench.lived[ray] - bench.taken[ray] for ray in bench.lived} == {bench.dut.latency}
        # A group per cycle, and then each ray of a live one.
        for codes, share in ((0, 1 + 1 / GRID_GROUP), (255, 1 / GRID_GROUP)):
            case.write(np.full(size, codes))
            await bench.swept(ctx)
            await bench.send(ctx, full)
            done = [*bench.lived.values(), *bench.dropped.values()]
            assert (max(done) - min(done)) / len(done) <= share + 0.05

    bench = SurvivalBench(case)
    assert bench.dut.latency == documented_latency(Survival, config)
    bench.run(test)
