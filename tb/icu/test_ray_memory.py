import random

import numpy as np
import pytest
from amaranth.sim import Simulator

from golden.icu.ray_memory import RayMemory as GoldenRayMemory
from hw.icu.ray_memory import RayMemory
from tb.lib.configurations import config_of

RAYS, FEW = 64, 4


async def transfer(ctx, stream, **payload):
    """Give one item, and return after how many cycles it was taken."""
    if payload:
        ctx.set(stream.payload, payload)
    ctx.set(stream.valid, 1)
    cycles = 0
    while True:
        *_, ready = await ctx.tick().sample(stream.ready)
        cycles += 1
        if ready:
            ctx.set(stream.valid, 0)
            return cycles


class Frusta:
    """Frusta of random updates, each read out under back-pressure and compared with golden's memory."""

    def __init__(self, generation_bits, *, few, seed, uv_bits=8):
        self.config = config_of({"icu.rays": RAYS, "icu.generation_bits": generation_bits, "icu.uv_bits": uv_bits})
        self.steps = 1 << uv_bits
        self.memory, self.random, self.few = RayMemory(config=self.config, tag=10), random.Random(seed), few
        self.frusta = 0

    async def update(self, ctx):
        """Updates in consecutive cycles, and (u, v) of the wins a few cycles after the answers.

        There may be few, so that rays are idle for as many frusta as there are tags.
        """
        memory, draw = self.memory, self.random
        rays = 1 + draw.randrange(FEW) if self.few else RAYS
        updates = [(draw.randrange(rays), draw.randrange(1, 50), draw.randrange(100), draw.random() < 0.8)
                   for _ in range(draw.choice((300, 40, 3)))]
        golden, uv, answers = GoldenRayMemory(RAYS, self.config), {}, 0
        for number in range(len(updates) + memory.latency + 1):
            given = number < len(updates)
            ctx.set(memory.i.valid, int(given))
            if given:
                ray, inverse, patch, hit = updates[number]
                ctx.set(memory.i.payload, {"tag": number, "ray": ray, "inverse": inverse, "patch": patch,
                                           "hit": int(hit)})
            *_, valid, answer = await ctx.tick().sample(memory.o.valid, memory.o.payload)
            ctx.set(memory.i_payload.valid, 0)
            if valid:
                assert answer.tag == answers, "answers must come in order, one for each update"
                ray, inverse, patch, hit = updates[answers]
                before = golden.inverse[ray], golden.patch[ray]
                if hit:
                    golden.update(np.array([ray]), np.array([inverse]), np.array([patch]))
                assert answer.won == (before != (golden.inverse[ray], golden.patch[ray]))
                if answer.won:
                    uv[ray] = answers % self.steps, answers % 7 % self.steps
                    ctx.set(memory.i_payload.valid, 1)
                    ctx.set(memory.i_payload.payload, {"ray": ray, "u": uv[ray][0], "v": uv[ray][1]})
                answers += 1
        await ctx.tick()
        ctx.set(memory.i_payload.valid, 0)
        assert answers == len(updates)
        return [(int(inverse), int(patch) if inverse else 0, *(uv[ray] if inverse else (0, 0)))
                for ray, (inverse, patch) in enumerate(zip(golden.inverse, golden.patch, strict=True))]

    async def read(self, ctx, bank):
        """All rays of a bank."""
        memory, found, requested = self.memory, [], 0
        while len(found) < RAYS:
            takes = self.random.random() < 0.6
            ctx.set(memory.o_read.ready, int(takes))
            ctx.set(memory.i_read.valid, int(requested < RAYS))
            ctx.set(memory.i_read.payload, {"bank": bank, "ray": min(requested, RAYS - 1)})
            *_, ready, valid, hit = await ctx.tick().sample(memory.i_read.ready, memory.o_read.valid,
                                                            memory.o_read.payload)
            requested += ready and requested < RAYS
            if valid and takes:
                found.append((int(hit.inverse), int(hit.patch), int(hit.u), int(hit.v)))
        ctx.set(memory.i_read.valid, 0)
        return found

    def run(self, testbench):
        simulator = Simulator(self.memory)
        simulator.add_clock(1e-8)
        simulator.add_testbench(testbench)
        simulator.run()
        assert self.frusta, "the bench must have come to its end"


@pytest.mark.parametrize(("generation_bits", "few"), [
    (1, False), (2, True), (4, False), *(pytest.param(*other, marks=pytest.mark.nightly) for other in (
        (1, True), (2, False), (4, True)))])
def test_the_nearest_hit_stays_over_many_frusta(generation_bits, few):
    frusta = Frusta(generation_bits, few=few, seed=generation_bits)

    async def testbench(ctx):
        # Of few rays the other rows are swept beside updates and reads.
        ctx.set(frusta.memory.rays, FEW if few else RAYS)
        for _ in range(14):
            await transfer(ctx, frusta.memory.i_start)
            expected = await frusta.update(ctx)
            assert await frusta.read(ctx, ctx.get(frusta.memory.active)) == expected
            frusta.frusta += 1

    frusta.run(testbench)


@pytest.mark.parametrize(("uv_bits", "generation_bits"), [(8, 4), (0, 1)])
def test_the_other_bank_keeps_its_frustum(uv_bits, generation_bits):
    frusta = Frusta(generation_bits, few=False, seed=9, uv_bits=uv_bits)

    async def testbench(ctx):
        before = None
        for _ in range(6):
            await transfer(ctx, frusta.memory.i_start)
            expected = await frusta.update(ctx)
            if before is not None:
                assert await frusta.read(ctx, 1 - ctx.get(frusta.memory.active)) == before
            before = expected
            frusta.frusta += 1

    frusta.run(testbench)


def test_a_bank_is_swept_only_when_its_tags_run_out():
    frusta = Frusta(2, few=False, seed=3)

    async def testbench(ctx):
        cycles = [await transfer(ctx, frusta.memory.i_start) for _ in range(14)]
        # Two banks by turns, three generations each.
        assert cycles == [RAYS + 1, RAYS + 1, 1, 1, 1, 1] * 2 + [RAYS + 1, RAYS + 1]
        frusta.frusta = 1

    frusta.run(testbench)
