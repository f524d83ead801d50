from functools import cache
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from golden.engine.icu.settle_code import scale, settle_code
from golden.engine.stimulus import block
from hw.icu.settle_map import SettleMap
from tb.lib.configurations import CONFIGURATIONS, config_of
from tb.lib.coverage import Coverage
from tb.lib.schedules import SETTINGS, Schedule, ScheduleBench, schedules

RAYS = 64
# Cycles after which a code can be read, as the docstring has it; from a start to the first read, and of the reads.
VISIBLE, WAIT, WALK, READ = 6, 4, 3, 4
WRITES = 60


def small(changes=None):
    return config_of({"icu.rays": RAYS, "icu.generation_bits": 2, **(changes or {})})


def tiles(config):
    return RAYS >> 2 * config.icu.tile_bits


def drawn_writes(config, random, *, some):
    """Rays and what they find, of each ray one after the other nearer; hard numbers of golden's among them. ``some``:
    only in the first words.
    """
    hard = block("icu.settle_code")[1].draw(random, 8, config)["inverse"]
    first, lost = scale(config)
    high = first + (config.icu.settle.high + 8 << lost)
    inverse = np.sort(np.concatenate([hard, random.integers(first, high, WRITES - len(hard))]))
    return random.integers(RAYS // 2 if some else RAYS, size=WRITES), np.maximum(inverse, 1)


def scheduled(times, items):
    """Items offered in some cycles, and accepted at once."""
    return [(at - before - 1, item) for before, at, item in zip([0, *times], times, items, strict=False)]


def compare(word, tile, at, writes):
    """A word that is read has all that came ``VISIBLE`` cycles before, of writes (cycle, ray, code), and nothing that
    was never written; of a ray that is being written 0.
    """
    for lane, code in enumerate(word):
        mine = [(when, found) for when, ray, found in writes if ray == tile * len(word) + lane and when <= at]
        is_written = any(when == at - VISIBLE + 1 for when, _ in mine)
        least = max([found for when, found in mine if when <= at - VISIBLE and not is_written], default=0)
        most = max([found for _, found in mine if not is_written], default=0)
        assert least <= code <= most, f"tile {tile} in cycle {at}: code {code}, not {least} to {most}"


@pytest.mark.parametrize("changes", [{}, *(
    pytest.param(changes, marks=pytest.mark.sim)
    for changes in ({"icu.tile_bits": 1}, {"icu.tile_bits": 3}, CONFIGURATIONS["narrow"]))],
                         ids=["default", "small tiles", "large tiles", "narrow"])
def test_codes_are_never_too_large_and_never_lost(changes):
    """Over more frusta than there are tags: writes in consecutive cycles while the window walk looks on; then both
    readers read all words.
    """
    config, random = small(changes), np.random.default_rng(3)
    coverage = Coverage(["smallest code", "largest code", "code between", "word of this frustum",
                         "word of an earlier frustum", "first write of a word", "tile in consecutive cycles",
                         "begun with a sweep", "begun without a sweep", "read of what is being written"])
    every, side = tiles(config), 2 * config.icu.tile_bits
    # Cycles of a frustum's start, which may take a sweep, of its first write, read and last reads, and of the next one.
    write, look, last = every + 1, every + WAIT, every + 1 + WRITES + VISIBLE
    period, frusta = last + every + WAIT, range(5)
    starts = [1 + period * number for number in frusta]
    given = [drawn_writes(config, random, some=number % 3 > 0) for number in frusta]
    codes = [settle_code(inverse, config).tolist() for _, inverse in given]
    writes = [[(start + write + k, int(ray), code) for k, (ray, code) in enumerate(zip(rays, found, strict=True))]
              for start, (rays, _), found in zip(starts, given, codes, strict=True)]
    reads = [[(start + at, int(rays[at - write] >> side) if at - write < WRITES and random.random() < 0.5 else
               int(random.integers(every))) for at in range(look, last)] for start, (rays, _) in zip(
                   starts, given, strict=True)]
    whole = [[(start + last + tile, tile) for tile in range(every)] for start in starts]
    walked, survival = [one for looks, ends in zip(reads, whole, strict=True) for one in looks + ends], [
        one for ends in whole for one in ends]
    takes = [every * (number % ((1 << config.icu.generation_bits) - 1) == 0) for number in frusta]
    bench = ScheduleBench(SettleMap(config=config, tag=16), idle_limit=40)
    came = bench.run(Schedule(items={
        "i_start": [(start - before - 1, 0) for before, start in zip(
            [0, *(start + cycles for start, cycles in zip(starts, takes, strict=True))], starts, strict=False)],
        "i": scheduled([at for one in writes for at, *_ in one], [
            {"ray": int(ray), "inverse": int(inverse)} for one in given for ray, inverse in zip(*one, strict=True)]),
        "i_walk": scheduled([at for at, _ in walked], [
            {"tag": number, "tile": tile} for number, (_, tile) in enumerate(walked)]),
        "i_read": scheduled([at for at, _ in survival], [tile for _, tile in survival])}))
    assert bench.cycles["i_start"] == [start + cycles for start, cycles in zip(starts, takes, strict=True)]
    assert [answer["tag"] for answer in came["o_walk"]] == list(range(len(walked)))
    assert bench.cycles["o_walk"] == [at + WALK for at, _ in walked]
    assert bench.cycles["o_read"] == [at + READ for at, _ in survival]
    for answers, tiles_read in (([answer["word"] for answer in came["o_walk"]], walked), (came["o_read"], survival)):
        for word, (at, tile) in zip(answers, tiles_read, strict=True):
            compare(word, tile, at, writes[(at - 1) // period])
    wrote = np.zeros(every, dtype=bool)
    for (rays, _), code, looks, cycles, made in zip(given, np.array(codes), reads, takes, writes, strict=True):
        tile, again = rays >> side, np.zeros(every, dtype=bool)
        again[tile] = True
        coverage.hit_all({
            "smallest code": code == 0, "largest code": code == config.icu.settle.high,
            "code between": (code > 0) & (code < config.icu.settle.high), "word of this frustum": again.any(),
            "word of an earlier frustum": wrote & ~again, "first write of a word": again & wrote,
            "tile in consecutive cycles": tile[1:] == tile[:-1],
            "begun with a sweep": cycles > 0, "begun without a sweep": cycles == 0,
            "read of what is being written": bool({(at + VISIBLE - 1, ray >> side) for at, ray, _ in made} & {*looks})})
        wrote |= again
    # Of a single word all is always written.
    if every > 1:
        coverage.check()


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
        compare(word, tile, at, written)


def test_one_read_per_cycle():
    _, bench = read_bench()
    bench.run(Schedule(items={"i_start": [(0, 0)], "i_read": [(20 * (k == 0), k % 4) for k in range(30)]}, stalls={}))
    requested, came = bench.cycles["i_read"], bench.cycles["o_read"]
    assert {b - a for a, b in pairwise(requested)} == {b - a for a, b in pairwise(came)} == {1}
    assert came[0] - requested[0] == 4


def test_reads_wait_while_no_word_is_accepted():
    _, bench = read_bench()
    came = bench.run(Schedule(items={"i_start": [(0, 0)], "i_read": [(20 * (k == 0), k % 4) for k in range(30)]},
                              stalls={"o_read": [90]}))["o_read"]
    assert len(came) == 30


def test_rows_are_swept_beside_writes():
    """Of a frustum of one tile, which begins when its row has been swept: no write is lost."""
    config = small({"icu.tile_bits": 1})
    bench = ScheduleBench(SettleMap(config=config, tag=1), ["i_start", "i", "i_read"], ["o_read"])
    first, lost = scale(config)
    inverse = [first + (5 + ray << lost) for ray in range(4)]
    writes = [(0 if ray else 4, {"ray": ray, "inverse": found}) for ray, found in enumerate(inverse)]
    word, = bench.run(Schedule(items={"i_start": [(0, 0)], "i": writes, "i_read": [(60, 0)]}), tiles=1)["o_read"]
    assert bench.cycles["i_start"][0] < bench.cycles["i"][0]
    assert bench.cycles["i"][-1] < tiles(config)
    assert word == settle_code(np.array(inverse), config).tolist()


def test_rays_that_are_not_listed_are_settled():
    """Of every second frustum all that was not written has the largest code, beside written rays too; nothing else."""
    config = small({"icu.shadow_bits": 6})
    first, lost = scale(config)
    bench = ScheduleBench(SettleMap(config=config, tag=1), ["i_start", "i", "i_walk", "i_read"], ["o_walk", "o_read"],
                          idle_limit=40, watched=())
    high, code = config.icu.settle.high, 5
    writes = [(20, {"ray": ray, "inverse": first + (code << lost)}) for ray in (3, 17)]
    reads = [(60 if tile == 0 else 0, tile) for tile in range(3)]
    for settled in (1, 0):
        came = bench.run(Schedule(items={
            "i_start": [(0, 0)], "i": writes, "i_read": reads,
            "i_walk": [(idle, {"tag": 0, "tile": tile}) for idle, tile in reads]}), settled=settled)
        rest = high * settled
        expected = [[code if 16 * tile + lane in (3, 17) else rest for lane in range(16)] for tile in range(3)]
        assert came["o_read"] == [one["word"] for one in came["o_walk"]] == expected
