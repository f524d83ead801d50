"""When a bank is swept, and what a read of one bank finds while the other one is updated; `tb.icu.test_read_out` has
their updates, stalls and resets.
"""

import random
from itertools import pairwise

import numpy as np

from golden.engine.icu.shadow_memory import ShadowMemory
from hw.icu.ray_memory import RayMemory
from tb.icu.shadow_frustum import random_shadow
from tb.lib.configurations import config_of
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.simulator import simulator_of

RAYS = 64


def test_a_bank_is_swept_only_when_its_tags_run_out():
    config = config_of({"icu.rays": RAYS, "icu.generation_bits": 2})
    bench = ScheduleBench(RayMemory(config=config, tag=10), ["i_start"], [], idle_limit=RAYS + 16)
    bench.run(Schedule(items={"i_start": [(0, 0)] * 14}), rays=RAYS)
    cycles, sweep = bench.cycles["i_start"], RAYS + 1
    assert cycles[0] - bench.trace.offered["i_start"][0] == RAYS
    # Two banks by turns, three generations each.
    assert [later - earlier for earlier, later in pairwise(cycles)] == [
        sweep, *[1] * 4, sweep, sweep, *[1] * 4, sweep, sweep]


def test_a_bank_is_read_while_the_other_one_is_updated():
    """A read finds the nearest hit of its bank's frustum, of equal ones that of the smaller patch, with (u, v)."""
    config, draw = config_of({"icu.rays": RAYS, "icu.generation_bits": 2}), random.Random(6)
    dut, banks, expected, found = RayMemory(config=config, tag=10), [{}, {}], [], []
    won, hit = dut.o.payload, dut.o_read.payload

    async def cycle(ctx, *, is_busy=False):
        """An update, and a read of the other bank; the (u, v) of a win come with the next cycle."""
        active, ray, inverse, patch = ctx.get(dut.active), *map(draw.randrange, (8, 20, 20))
        ctx.set(dut.i.valid, is_busy)
        ctx.set(dut.i.payload, {"ray": ray, "inverse": 1 + inverse, "patch": patch, "hit": 1})
        if is_busy:
            old = banks[active].setdefault(ray, [0, 0, 0, 0])
            old[:2] = max((old[:2], [1 + inverse, patch]), key=lambda key: (key[0], -key[1]))
        ctx.set(dut.i_read.valid, is_busy)
        ctx.set(dut.i_read.payload, {"bank": 1 - active, "ray": ray})
        if is_busy and ctx.get(dut.i_read.ready):
            expected.append(banks[1 - active].get(ray, [0, 0, 0, 0]))
        if ctx.get(dut.o_read.valid):
            found.append([ctx.get(hit[name]) for name in ("inverse", "patch", "u", "v")])
        wins, which, uv = ctx.get(dut.o.valid & won.won), ctx.get(won.ray), [draw.randrange(1 << 8) for _ in "uv"]
        if wins:
            banks[active][which][2:] = uv
        await ctx.tick()
        ctx.set(dut.i_payload.valid, wins)
        ctx.set(dut.i_payload.payload, {"ray": which, "u": uv[0], "v": uv[1]})

    async def bench(ctx):
        ctx.set(dut.rays, RAYS)
        ctx.set(dut.o_read.ready, 1)
        for _ in range(6):
            ctx.set(dut.i_start.valid, 1)
            await ctx.tick().until(dut.i_start.ready)
            ctx.set(dut.i_start.valid, 0)
            banks[ctx.get(dut.active)] = {}
            for number in range(70):
                await cycle(ctx, is_busy=number < 50)

    simulator_of(dut, bench).run()
    assert found == expected
    assert sum(map(any, found)) > 200


def test_a_ray_is_blocked_before_its_end_alone():
    """In each second frustum; the others have the nearest hit. Listed rays come first; others are never hit, whatever
    the bank held before.
    """
    config = config_of({"icu.rays": 256, "icu.generation_bits": 2, "icu.shadow_bits": 8})
    random, dut = np.random.default_rng(2), RayMemory(config=config, tag=10)
    high, blocked = config.numbers.inverse.high, 0

    async def update(ctx, items):
        for item in items:
            ctx.set(dut.i.payload, item)
            ctx.set(dut.i_payload.payload, {"ray": item["ray"], "u": 1, "v": 2})
            ctx.set(dut.i.valid, 1)
            ctx.set(dut.i_payload.valid, 1)
            await ctx.tick()
        ctx.set(dut.i.valid, 0)
        ctx.set(dut.i_payload.valid, 0)
        await ctx.tick().repeat(8)

    async def read(ctx):
        found = []
        ctx.set(dut.i_read.valid, 1)
        for ray in range(256):
            ctx.set(dut.i_read.payload, {"bank": ctx.get(dut.active), "ray": ray})
            _, _, valid, hit = await ctx.tick().sample(dut.o_read.valid, dut.o_read.payload)
            found += [hit] if valid else []
        ctx.set(dut.i_read.valid, 0)
        while len(found) < 256:
            _, _, valid, hit = await ctx.tick().sample(dut.o_read.valid, dut.o_read.payload)
            found += [hit] if valid else []
        return [(hit.inverse, hit.patch, hit.u, hit.v) for hit in found]

    async def bench(ctx):
        nonlocal blocked
        ctx.set(dut.rays, 256)
        ctx.set(dut.o_read.ready, 1)
        for number in range(8):
            is_shadow, record = number % 4 < 2, random_shadow(random, config, bits=4)
            ctx.set(dut.is_shadow, is_shadow)
            ctx.set(dut.i_start.valid, 1)
            await ctx.tick().until(dut.i_start.ready)
            ctx.set(dut.i_start.valid, 0)
            listed = np.flatnonzero(record.end < high)
            if is_shadow:
                await update(ctx, [{"tag": 0, "ray": ray, "inverse": int(record.end[ray]), "patch": 9, "hit": 0,
                                    "lists": 1} for ray in listed.tolist()])
            ray = random.integers(256, size=300)
            # Before the end, at it and behind it.
            inverse = np.clip(record.end[ray] + random.integers(-1, 2, 300), 1, high)
            hit = random.random(300) < 0.8
            await update(ctx, [{"tag": 0, "ray": which, "inverse": near, "patch": k, "hit": int(hit[k]), "lists": 0}
                               for k, (which, near) in enumerate(zip(ray.tolist(), inverse.tolist(), strict=True))])
            found = await read(ctx)
            if is_shadow:
                memory = ShadowMemory(record, config)
                memory.update(ray[hit], inverse[hit], None)
                assert found == [(high, 0, 0, 0) if one else (0, 0, 0, 0) for one in memory.blocked.tolist()]
                blocked += int(memory.blocked.sum())
            else:
                best = np.zeros(256, dtype=np.int64)
                np.maximum.at(best, ray[hit], inverse[hit])
                assert [one[0] for one in found] == best.tolist()

    simulator_of(dut, bench).run()
    assert blocked > 100
