"""When a bank is swept, and what a read of one bank finds while the other one is updated; `tb.icu.test_read_out` has
their updates, stalls and resets.
"""

import random
from itertools import pairwise

from amaranth.sim import Simulator

from hw.icu.ray_memory import RayMemory
from tb.lib.configurations import config_of
from tb.lib.schedules import Schedule, ScheduleBench

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

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    assert found == expected
    assert sum(map(any, found)) > 200
