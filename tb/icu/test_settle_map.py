# amaranth: UnusedElaboratable=no

from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from amaranth.sim import Simulator
from hypothesis import given
from hypothesis import strategies as st

from golden.icu.settle_code import scale, settle_code
from golden.stimulus import block
from hw.icu.settle_map import SettleMap
from tb.lib.configurations import CONFIGURATIONS, config_of
from tb.lib.coverage import Coverage
from tb.lib.schedules import SETTINGS, Schedule, ScheduleBench, schedules

RAYS = 64
# Cycles after which a code can be read, as the docstring has it.
VISIBLE = 6


def small(changes=None):
    return config_of({"icu.rays": RAYS, "icu.generation_bits": 2, **(changes or {})})


def tiles(config):
    return RAYS >> 2 * config.icu.tile_bits


def words(codes, config):
    """Codes of all rays as words."""
    return codes.reshape(tiles(config), -1).tolist()


class Frusta:
    """Frusta of writes in consecutive cycles, ever nearer for each ray, while both readers look on."""

    def __init__(self, config, *, seed):
        self.config, self.random = config, np.random.default_rng(seed)
        self.map = SettleMap(config=config, tag=8)
        self.coverage = Coverage(["smallest code", "largest code", "code between", "word of this frustum",
                                  "word of an earlier frustum", "first write of a word", "tile in consecutive cycles",
                                  "begun with a sweep", "begun without a sweep", "read of what is being written"])
        self.wrote, self.number = np.zeros(tiles(config), dtype=bool), 0

    def draw(self, count):
        """Rays and what they find, of each ray one after the other nearer; hard numbers of golden's among them."""
        config = self.config
        hard = block("icu.settle_code")[1].draw(self.random, 8, config)["inverse"]
        first, lost = scale(config)
        high = first + (config.icu.settle.high + 8 << lost)
        inverse = np.sort(np.concatenate([hard, self.random.integers(first, high, count - len(hard))]))
        # Every third frustum writes only some of the words.
        self.number += 1
        return self.random.integers(RAYS // 2 if self.number % 3 == 0 else RAYS, size=count), np.maximum(inverse, 1)

    async def begin(self, ctx):
        """Begin a frustum."""
        ctx.set(self.map.i_start.valid, 1)
        cycles = 1
        while not (await ctx.tick().sample(self.map.i_start.ready))[-1]:
            cycles += 1
            assert cycles <= tiles(self.config) + 1, "the watchdog waited for the frustum"
        ctx.set(self.map.i_start.valid, 0)
        self.coverage.hit("begun with a sweep" if cycles > 1 else "begun without a sweep")
        assert cycles in (1, tiles(self.config) + 1)

    async def cast(self, ctx, count=60):
        """One frustum."""
        config, block_ = self.config, self.map
        ray, inverse = self.draw(count)
        code = settle_code(inverse, config)
        side = 2 * config.icu.tile_bits
        history = np.zeros((count + VISIBLE + 8, RAYS), dtype=np.int64)
        for k in range(count):
            history[k + 1:, ray[k]] = code[k]
        await self.begin(ctx)
        read_tiles = []
        for cycle in range(len(history) - 1):
            written = cycle < count
            ctx.set(block_.i.valid, int(written))
            if written:
                ctx.set(block_.i.payload, {"ray": int(ray[cycle]), "inverse": int(inverse[cycle])})
            tile = int(ray[cycle] >> side) if written and self.random.random() < 0.5 \
                else int(self.random.integers(tiles(config)))
            ctx.set(block_.i_walk.valid, 1)
            ctx.set(block_.i_walk.payload, {"tag": cycle, "tile": tile})
            read_tiles.append(tile)
            *_, valid, answer = await ctx.tick().sample(block_.o_walk.valid, block_.o_walk.payload)
            assert valid == (cycle >= block_.latency), "an answer comes in every cycle, after the latency"
            if valid:
                issued = cycle - block_.latency
                assert answer.tag == issued
                self.compare(list(answer.word), history, issued, read_tiles[issued])
        ctx.set(block_.i_walk.valid, 0)
        tile, again = ray >> side, np.zeros(tiles(config), dtype=bool)
        again[tile] = True
        self.coverage.hit_all({
            "smallest code": code == 0, "largest code": code == config.icu.settle.high,
            "code between": (code > 0) & (code < config.icu.settle.high),
            "word of this frustum": again.any(), "word of an earlier frustum": self.wrote & ~again,
            "first write of a word": again & self.wrote,
            "tile in consecutive cycles": tile[1:] == tile[:-1],
            "read of what is being written": [read_tiles[k] == tile[k] for k in range(count)]})
        self.wrote = again | self.wrote
        await ctx.tick().repeat(block_.latency + 1)
        return history[-1]

    def compare(self, word, history, issued, tile):
        """Nothing that was never written, all that came ``VISIBLE`` cycles before."""
        lanes = slice(tile * len(word), (tile + 1) * len(word))
        sure = history[max(issued - VISIBLE + 1, 0), lanes]
        for code, least, most in zip(word, sure, history[issued + 1, lanes], strict=True):
            assert least <= code <= most, f"tile {tile} in cycle {issued}: code {code}, not {least} to {most}"

    def run(self, frusta):
        """As many frusta as given, more than there are tags; after each both copies have all that was written."""
        done = []

        async def testbench(ctx):
            for _ in range(frusta):
                expected = words(await self.cast(ctx), self.config)
                for tile, word in enumerate(expected):
                    ctx.set(self.map.i_walk.valid, 1)
                    ctx.set(self.map.i_walk.payload.tile, tile)
                    ctx.set(self.map.i_read.valid, 1)
                    ctx.set(self.map.i_read.payload, tile)
                    ctx.set(self.map.o_read.ready, 1)
                    await ctx.tick()
                    ctx.set(self.map.i_walk.valid, 0)
                    ctx.set(self.map.i_read.valid, 0)
                    await ctx.tick().repeat(self.map.latency - 1)
                    assert list(ctx.get(self.map.o_walk.payload.word)) == word
                    await ctx.tick()
                    assert ctx.get(self.map.o_read.valid)
                    assert list(ctx.get(self.map.o_read.payload)) == word
                    await ctx.tick()
                done.append(True)

        simulator = Simulator(self.map)
        simulator.add_clock(1e-8)
        simulator.add_testbench(testbench)
        simulator.run()
        assert len(done) == frusta


@pytest.mark.parametrize("changes", [{}, {"icu.tile_bits": 1}, {"icu.tile_bits": 3}, CONFIGURATIONS["narrow"]],
                         ids=["default", "small tiles", "large tiles", "narrow"])
def test_codes_are_never_too_large_and_never_lost(changes):
    frusta = Frusta(small(changes), seed=3)
    frusta.run(5)
    # Of a single word all is always written.
    if tiles(frusta.config) > 1:
        frusta.coverage.check()


@cache
def read_bench():
    config = small()
    return config, ScheduleBench(SettleMap(config=config, tag=1), ["i_start", "i", "i_read"], ["o_read"])


@SETTINGS
@given(schedules({"i": st.tuples(st.integers(0, RAYS - 1), st.integers(1, 80)),
                  "i_read": st.integers(0, (RAYS >> 4) - 1)}, ["o_read"]))
def test_cell_traversal_reads_in_order_and_what_is_there(drawn):
    """Under any stalls: a read gives what is there when it was taken, or what was there up to some cycles before."""
    config, bench = read_bench()
    first, lost = scale(config)
    best, writes = np.zeros(RAYS, dtype=np.int64), []
    # After the sweep; nearer hits of a ray come one after the other.
    for number, (idle, (ray, step)) in enumerate(drawn.items["i"]):
        best[ray] += step << lost - 1
        writes.append((idle + (30 if number == 0 else 0), {"ray": ray, "inverse": int(first + best[ray])}))
    reads = [(idle + (30 if number == 0 else 0), tile) for number, (idle, tile) in enumerate(drawn.items["i_read"])]
    came = bench.run(Schedule(items={"i_start": [(0, 0)], "i": writes, "i_read": reads}, stalls=drawn.stalls))["o_read"]
    assert len(came) == len(reads)
    codes = settle_code(np.array([write["inverse"] for _, write in writes], dtype=np.int64), config).tolist()
    written = [(at, write["ray"], code) for at, (_, write), code in zip(bench.cycles["i"], writes, codes, strict=True)]
    for at, (_, tile), word in zip(bench.cycles["i_read"], reads, came, strict=True):
        for lane, code in enumerate(word):
            mine = [(when, found) for when, ray, found in written if ray == tile * len(word) + lane]
            least = max([found for when, found in mine if when <= at - VISIBLE], default=0)
            most = max([found for when, found in mine if when <= at], default=0)
            assert least <= code <= most


def test_one_read_per_cycle():
    _, bench = read_bench()
    bench.run(Schedule(items={"i_start": [(0, 0)], "i_read": [(20 * (k == 0), k % 4) for k in range(30)]}, stalls={}))
    requested, came = bench.cycles["i_read"], bench.cycles["o_read"]
    assert {b - a for a, b in pairwise(requested)} == {b - a for a, b in pairwise(came)} == {1}
    assert came[0] - requested[0] == 4
