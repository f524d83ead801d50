"""Stages are over in their order, and none too early."""

from collections import Counter

import numpy as np
import pytest
from amaranth.sim import Simulator

from hw.ctu.ctu_formats import GRID_GROUP
from hw.ctu.stage_count import NEAR_STAGE, StageCount
from tb.lib.configurations import config_of
from tb.lib.timing import documented_latency

LEAVES, STAGES = 3, 20


@pytest.mark.parametrize(("run_ahead", "seed"), [(0, 1), (1, 2), (2, 3), (5, 4)])
def test_random_stages(run_ahead, seed):
    """Rays come and go in any order, and what their cells lead to ends some time later; of two frusta."""
    config = config_of({"ctu.run_ahead": run_ahead})
    dut, random = StageCount(config=config, exits=LEAVES), np.random.default_rng(seed)
    assert dut.latency == documented_latency(StageCount, config)
    # By stage, counted from the near cells' on: rays in flight, the cycle until which its cells lead to something,
    # whether it is closed, and when nothing was left of it.
    rays, until, closed, quiet = {}, {}, set(), {}

    async def frustum(ctx):
        for one in rays, until, closed, quiet:
            one.clear()
        over = newest = 0
        cycle, done, was_busy = 0, False, False
        ctx.set(dut.begins, 1)
        await ctx.tick()
        ctx.set(dut.begins, 0)
        while not done:
            cycle += 1
            assert cycle < 20_000, "the bench hangs"
            near = newest == 0
            enters = 0
            if not near and newest < STAGES and newest - over <= run_ahead and random.random() < 0.4:
                enters = int(random.integers(1, GRID_GROUP, endpoint=True))
            closes = newest < STAGES and newest - over <= run_ahead and random.random() < 0.1
            leaving = []
            left = Counter(rays)
            for stage in random.permutation([stage for stage, count in rays.items() for _ in range(count)])[:LEAVES]:
                if random.random() < 0.3 and left[int(stage)]:
                    count = int(random.integers(1, min(GRID_GROUP, left[int(stage)]), endpoint=True))
                    left[int(stage)] -= count
                    leaving.append((int(stage), count))
            if enters:
                rays[newest] = rays.get(newest, 0) + enters
            ctx.set(dut.enters.valid, int(enters > 0))
            ctx.set(dut.enters.payload, {"stage": (newest + NEAR_STAGE) % 16, "count": enters})
            for exit_index in range(LEAVES):
                ctx.set(dut.left[exit_index].valid, int(exit_index < len(leaving)))
                if exit_index < len(leaving):
                    stage, count = leaving[exit_index]
                    ctx.set(dut.left[exit_index].payload, {"stage": (stage + NEAR_STAGE) % 16, "count": count})
                    rays[stage] -= count
                    if random.random() < 0.5:
                        until[stage] = cycle + int(random.integers(1, 40))
            ctx.set(dut.closes, int(closes))
            ctx.set(dut.closed_all, int(newest == STAGES))
            # What leaves in this cycle is settled no more in the next one.
            ctx.set(dut.settled, not was_busy)
            was_busy = any(end >= cycle for end in until.values())
            if closes:
                closed.add(newest)
                newest += 1
            for stage in closed:
                if not rays.get(stage) and until.get(stage, 0) <= cycle:
                    quiet.setdefault(stage, cycle)
            *_, is_over, near_over, finished = await ctx.tick().sample(dut.over, dut.near_over, dut.done)
            if is_over:
                assert over in quiet, f"stage {over} is over too early"
                over += 1
            assert near_over == (over > (1 if is_over else 0)) or is_over
            done = finished
        assert over == STAGES

    async def testbench(ctx):
        for _ in range(2):
            await frustum(ctx)

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(testbench)
    simulator.run()


def test_latency():
    """A stage ends one cycle after it is closed, or three cycles after its last ray ends."""
    dut, ends = StageCount(config=config_of({}), exits=1), []

    async def drive(ctx):
        ctx.set(dut.settled, 1)
        # By cycle: what is 1 in it.
        for cycle in range(20):
            for port, when in ((dut.begins, 0), (dut.enters.valid, 5), (dut.left[0].valid, 9)):
                ctx.set(port, int(cycle == when))
            ctx.set(dut.closes, int(cycle in (3, 5)))
            for port in dut.enters, dut.left[0]:
                ctx.set(port.payload, {"stage": 0, "count": 4})
            *_, over = await ctx.tick().sample(dut.over)
            ends.extend([cycle] * over)

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(drive)
    simulator.run()
    assert ends == [3 + 1, 9 + documented_latency(StageCount, config_of({}))]
