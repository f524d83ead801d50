"""Groups come apart into their rays, in order, one per cycle."""

import random
from itertools import pairwise

import pytest
from amaranth.lib.data import StructLayout
from amaranth.sim import Simulator

from golden.config import PRESETS
from hw.ctu.ctu_formats import GRID_GROUP
from hw.ctu.group_split import GroupSplit
from tb.lib.stall_patterns import STALLS
from tb.lib.timing import documented_latency

RAY = StructLayout({"ray": 12, "column": 10, "stage": 4})
GROUPS = 200


def run(groups, *, source="none", sink="none"):
    """The rays with their cycles, the cycle of the first group, and how often one has left its place."""
    dut = GroupSplit(RAY)
    stalls, stops = STALLS[source](1), STALLS[sink](2)
    came, taken, left = [], [], 0

    async def drive(ctx):
        for first, count in groups:
            while next(stalls):
                ctx.set(dut.i.valid, 0)
                await ctx.tick()
            ctx.set(dut.i.payload, {"first": first, "count": count})
            ctx.set(dut.i.valid, 1)
            await ctx.tick().until(dut.i.ready)
        ctx.set(dut.i.valid, 0)

    async def take(ctx):
        nonlocal left
        wanted, cycle = sum(count for _, count in groups), 0
        while len(came) < wanted:
            ready = not next(stops)
            ctx.set(dut.o.ready, ready)
            _, _, given, leaves, valid, ray = await ctx.tick().sample(
                dut.i.valid & dut.i.ready, dut.leaves, dut.o.valid, dut.o.payload)
            cycle += 1
            assert cycle < 100 * GROUPS, "the bench hangs"
            if given:
                taken.append(cycle)
            left += leaves
            if valid and ready:
                came.append((cycle, {name: ray[name] for name in RAY.members}))

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(drive)
    simulator.add_testbench(take)
    simulator.run()
    return came, taken[0], left, dut.latency


def drawn(seed):
    generator = random.Random(seed)
    return [({"ray": generator.randrange(4000), "column": generator.randrange(1000), "stage": generator.randrange(16)},
             generator.randint(1, GRID_GROUP)) for _ in range(GROUPS)]


@pytest.mark.parametrize(("source", "sink"), [("none", "none"), ("random", "bursts"), ("bursts", "random")])
def test_every_ray_once_and_in_order(source, sink):
    groups = drawn(3)
    came, _, left, _ = run(groups, source=source, sink=sink)
    assert [ray for _, ray in came] == [
        {**first, "ray": first["ray"] + k, "column": first["column"] + k} for first, count in groups
        for k in range(count)]
    assert left == len(groups), "each group must make room once"


def test_a_ray_per_cycle_after_the_latency():
    came, first, _, latency = run(drawn(4))
    assert latency == documented_latency(GroupSplit, PRESETS["tiny"]) == came[0][0] - first
    assert {after - before for (before, _), (after, _) in pairwise(came)} == {1}
