"""Items of released chains in their order; `tb/formal/memsys/test_deferred_store.py` proves it of small stores."""

import random

import pytest
from amaranth.hdl import Value
from amaranth.sim import Simulator

from hw.memsys.patches.deferred_store import DeferredStore


def bits(layout, values):
    """The number that a structure holds; `StructLayout.const` takes several times as long."""
    return sum((bits(layout[name].shape, value) if isinstance(value, dict) else value) << layout[name].offset
               for name, value in values.items())


@pytest.mark.parametrize(("depth", "owners"), [
    (1, 2), (6, 3), *(pytest.param(*one, marks=pytest.mark.sim) for one in ((3, 2), (4, 4), (8, 5)))])
def test_chains_of_several_owners(depth, owners):
    """What an owner keeps of a chain that has been released says nothing: its next chain begins with its next item.
    Items of one chain leave without those of another one between them.
    """
    dut, rng = DeferredStore(16, depth=depth, tag=12), random.Random(depth)
    streams = dut.i, dut.i_release
    (added, released), (item, release) = zip(*((Value.cast(one.payload), one.payload.shape()) for one in streams),
                                             strict=True)
    leaves, moves = (dut.o.payload.tag, dut.o.payload.data), dut.o.valid & dut.o.ready
    waiting, expected, came = [[] for _ in range(owners)], [], []

    async def bench(ctx):
        chains = [dict.fromkeys(("some", "first", "last"), 0) for _ in range(owners)]
        for number in range(200 * depth):
            # A chain that an item enters is not released.
            adds, offers = rng.randrange(owners), ctx.get(dut.i.ready) and rng.random() < 0.7
            ends = [one for one in range(owners) if chains[one]["some"] and not (offers and one == adds)]
            releases, frees = bool(ends) and rng.random() < 0.3, rng.choice(ends or [0])
            if not chains[adds]["some"]:
                chains[adds] |= {name: rng.randrange(depth) for name in ("first", "last")}
            ctx.set(dut.i.valid, int(offers))
            ctx.set(added, bits(item, {"tag": number, "chain": chains[adds]}))
            ctx.set(dut.i_release.valid, int(releases))
            ctx.set(released, bits(release, {"chain": chains[frees], "data": 5 * number}))
            ctx.set(dut.o.ready, rng.random() < 0.8)
            if offers:
                waiting[adds].append(number)
                chains[adds] = {name: ctx.get(dut.longer[name]) for name in chains[adds]}
            if releases:
                expected.extend((one, 5 * number) for one in waiting[frees])
                waiting[frees], chains[frees]["some"] = [], 0
            assert ctx.get(dut.releases) == (releases or len(came) < len(expected)), "releases go on"
            if ctx.get(moves):
                came.append(tuple(map(ctx.get, leaves)))
            await ctx.tick()
        ctx.set(dut.i.valid, 0)
        ctx.set(dut.i_release.valid, 0)
        ctx.set(dut.o.ready, 1)
        for _ in range(2 * depth + 8):
            if ctx.get(dut.o.valid):
                came.append(tuple(map(ctx.get, leaves)))
            await ctx.tick()
        assert ctx.get(dut.waiting) == sum(map(len, waiting))

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    assert came == expected
    assert len(came) > 20 * depth
