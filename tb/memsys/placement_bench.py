"""Testbench of a placement: requests in, lines out, as golden has them, with starts in between."""

import random

import numpy as np
from amaranth.sim import Simulator

__all__ = ["STRINGS", "run"]

# Keys that come again at once, after any number of others, and never; that share sets, and that do not.
STRINGS = {
    "random": lambda draw, lines: draw.integers(0, 2 * lines, 120),
    "few": lambda draw, lines: draw.integers(0, 3, 60) * lines,
    "skewed": lambda draw, lines: np.minimum(draw.geometric(1 / lines, 120), 255),
    "loop": lambda draw, lines: np.arange(100) % (lines + 1),
}
TAGS = 64


def run(placement, golden, strings, *, gaps: bool, seed: int, ports: dict | None = None) -> dict:
    """Asserts that each string, from an empty placement on, has golden's hits and lines.

    Returns
    -------
    Of the last string: ``hit`` of each request, and the cycles in which requests were taken and answered (``taken``,
    ``came``).
    """
    draw, seen, expected, done = random.Random(seed), {"taken": [], "came": [], "hit": []}, [], []

    async def give(ctx, stream, payload=None):
        """Offer one item until it is taken."""
        if payload is not None:
            ctx.set(stream.payload, payload)
        ctx.set(stream.valid, 1)
        taken = 0
        while not taken:
            *_, taken = await ctx.tick().sample(stream.valid if stream.signature.always_ready else stream.ready)
        ctx.set(stream.valid, 0)

    async def drive(ctx):
        for port, value in (ports or {}).items():
            ctx.set(getattr(placement, port), value)
        for keys in strings:
            golden.clear()
            hit, line, _ = golden.access(keys)
            expected[:] = zip(np.arange(len(keys)) % TAGS, line, hit, strict=True)
            for values in seen.values():
                values.clear()
            await give(ctx, placement.i_start)
            for number, key in enumerate(keys):
                while gaps and draw.random() < 0.4:
                    await ctx.tick()
                await give(ctx, placement.i, {"tag": number % TAGS, "key": int(key)})
            await ctx.tick().repeat(30)
            assert len(seen["hit"]) == len(keys), "each request must be answered once"
        done.append(True)

    async def watch(ctx):
        cycle, i, o = 0, placement.i, placement.o
        while not done:
            *_, requests, ready, valid, answer = await ctx.tick().sample(
                i.valid, i.valid if i.signature.always_ready else i.ready, o.valid, o.payload)
            cycle += 1
            if requests and ready:
                seen["taken"].append(cycle)
            if valid:
                number = len(seen["hit"])
                assert (answer.tag, answer.line, answer.hit) == expected[number], f"request {number}, seed {seed}"
                seen["hit"].append(bool(answer.hit))
                seen["came"].append(cycle)

    simulator = Simulator(placement)
    simulator.add_clock(1e-8)
    simulator.add_testbench(drive)
    simulator.add_testbench(watch)
    simulator.run()
    assert done, "the bench must have come to its end"
    return seen
