"""Loads step by step, with units that take their time."""

import random

import pytest
from amaranth.sim import Simulator

from golden.config import PRESETS
from hw.control.load_control import ALL, LoadControl
from hw.memsys.fault import Fault
from hw.memsys.image_layout import RegionNumber
from hw.memsys.preload_dma import OWN
from tb.lib.timing import documented_latency

CONFIG = PRESETS["tiny"].replace({"noc.columns": 4, "noc.rows": 1})
CLUSTERS = 4


def run(dut, bench):
    async def testbench(ctx):
        await bench(ctx)

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(testbench)
    simulator.run()


def load(regions, faults=(), *, image=64, copies=0, seed=1):
    """Commands, words by (cluster, is_all, record), and how it ended; DMA and clusters take their time."""
    dut, draw = LoadControl(config=CONFIG), random.Random(seed)
    commands, words, overs = [], [], []

    async def bench(ctx):
        state, left, record, pending, stored = "idle", 0, 0, 0, 0
        ctx.set(dut.i.payload, {"image": image, "regions": regions, "copies": copies})
        ctx.set(dut.i.valid, 1)
        for cycle in range(4000):
            ctx.set(dut.o_command.ready, state == "idle" and draw.random() < 0.5)
            ctx.set(dut.i_word.valid, state == "words" and draw.random() < 0.7)
            ctx.set(dut.i_word.payload, {"region": RegionNumber.CELLS, "record": record, "word": 0, "data": 5})
            ctx.set(dut.i_done.valid, state == "done")
            ctx.set(dut.i_done.payload.code, dict(faults).get(len(commands) - 1, Fault.NONE))
            ctx.set(dut.o_word.ready, draw.random() < 0.6)
            pending = max(0, pending - 1)
            ctx.set(dut.stored, pending == 0)
            stored = 0 if pending or state != "idle" else stored + 1
            if ctx.get(dut.o_command.valid) and ctx.get(dut.o_command.ready):
                command = dut.o_command.payload
                commands.append((ctx.get(command.image), ctx.get(command.cluster), ctx.get(command.regions)))
                state, left = "words", 4
            elif state == "words" and ctx.get(dut.i_word.valid) and ctx.get(dut.i_word.ready):
                out = dut.o_word.payload
                words.append((ctx.get(out.cluster), ctx.get(out.is_all), ctx.get(out.item.record)))
                record, left, pending = record + 1, left - 1, 1 + draw.randrange(30)
                state = "words" if left else "done"
            elif state == "done" and ctx.get(dut.i_done.ready):
                state = "idle"
            if ctx.get(dut.o_over.valid):
                assert not pending, "a load ends when all words are stored"
                assert stored <= 3, "and waits for nothing else"
                overs.append(Fault(ctx.get(dut.o_over.payload.code)))
            taken = ctx.get(dut.i.ready)
            await ctx.tick()
            if taken and cycle == 0:
                ctx.set(dut.i.valid, 0)
                # The host may write other numbers from now on.
                ctx.set(dut.i.payload, {"image": 1, "regions": ~regions & ALL, "copies": 1 - copies})
            if overs:
                await ctx.tick()
                assert not ctx.get(dut.busy)
                break

    run(dut, bench)
    return commands, words, overs


def test_shared_tables_come_before_each_clusters_own():
    commands, words, overs = load(ALL)
    assert commands == [(64, 0, ALL & ~OWN), *((64, k, ALL & OWN) for k in range(CLUSTERS))]
    assert words == [(0 if k < 4 else k // 4 - 1, int(k < 4), k) for k in range(4 * (CLUSTERS + 1))]
    assert overs == [Fault.NONE]


def test_copies_are_read_once_for_all_clusters():
    commands, words, overs = load(ALL, copies=1)
    assert commands == [(64, 0, ALL)]
    assert words == [(0, 1, k) for k in range(4)]
    assert overs == [Fault.NONE]


@pytest.mark.parametrize("copies", [0, 1])
def test_without_regions_of_its_own_no_cluster_is_loaded_alone(copies):
    commands, words, overs = load(ALL & ~OWN, copies=copies, seed=2)
    assert (commands, overs) == ([(64, 0, ALL & ~OWN)], [Fault.NONE])
    assert {is_all for _, is_all, _ in words} == {1}


@pytest.mark.parametrize("at", [0, 2])
def test_a_fault_ends_a_load(at):
    commands, _, overs = load(ALL, {at: Fault.POINTER}, seed=3)
    assert (len(commands), overs) == (at + 1, [Fault.POINTER])


def test_a_fault_of_copies():
    commands, _, overs = load(ALL, {0: Fault.SIZE}, copies=1, seed=3)
    assert (len(commands), overs) == (1, [Fault.SIZE])


def test_the_load_after_a_fault_begins_with_the_shared_tables():
    """Also if the fault was in the tables of a cluster."""
    dut, commands, overs = LoadControl(config=CONFIG), [], []

    async def bench(ctx):
        ctx.set(dut.i.payload, {"image": 64, "regions": ALL, "copies": 0})
        for always in dut.i.valid, dut.o_command.ready, dut.i_done.valid, dut.stored:
            ctx.set(always, 1)
        while len(overs) < 2:
            if ctx.get(dut.o_command.valid):
                commands.append((ctx.get(dut.o_command.payload.cluster), ctx.get(dut.o_command.payload.regions)))
            ctx.set(dut.i_done.payload.code, Fault.POINTER if len(commands) == 3 else Fault.NONE)
            if ctx.get(dut.o_over.valid):
                overs.append(Fault(ctx.get(dut.o_over.payload.code)))
            await ctx.tick()

    run(dut, bench)
    whole = [(0, ALL & ~OWN), *((k, ALL & OWN) for k in range(CLUSTERS))]
    assert (commands, overs) == (whole[:3] + whole, [Fault.POINTER, Fault.NONE])


def test_latency():
    dut, found = LoadControl(config=CONFIG), []

    async def bench(ctx):
        ctx.set(dut.i.payload, {"image": 64, "regions": ALL, "copies": 0})
        ctx.set(dut.i.valid, 1)
        for cycle in range(5):
            if ctx.get(dut.o_command.valid):
                found.append(cycle)
            await ctx.tick()

    run(dut, bench)
    assert found[0] == documented_latency(LoadControl, CONFIG) == LoadControl.latency


@pytest.mark.parametrize("image", [1, 32, 4096 + 8, 1 << CONFIG.memory.address_bits, 1 << 63])
def test_an_image_is_at_an_address_that_is_a_multiple_of_64(image):
    assert load(ALL, image=image) == ([], [], [Fault.IMAGE])


def test_the_fault_of_an_image_has_its_address_and_not_that_of_the_load_before():
    dut, overs, images = LoadControl(config=CONFIG), [], [64, 4096 + 8, 32]

    async def bench(ctx):
        for always in dut.i.valid, dut.o_command.ready, dut.i_done.valid, dut.stored:
            ctx.set(always, 1)
        ctx.set(dut.i_done.payload, {"code": Fault.POINTER, "address": 0x3000})
        while len(overs) < len(images):
            ctx.set(dut.i.payload, {"image": images[len(overs)], "regions": ALL, "copies": 0})
            if ctx.get(dut.o_over.valid):
                overs.append((Fault(ctx.get(dut.o_over.payload.code)), ctx.get(dut.o_over.payload.address)))
            await ctx.tick()

    run(dut, bench)
    assert overs == [(Fault.POINTER, 0x3000), (Fault.IMAGE, 4096 + 8), (Fault.IMAGE, 32)]
