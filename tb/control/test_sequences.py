"""Loads, casts and results, step by step, with units that take their time."""

import random

import pytest
from amaranth.sim import Simulator

from golden.config import PRESETS
from hw.control.cast_control import CastControl
from hw.control.load_control import ALL, OWN, LoadControl
from hw.control.result_control import ResultControl
from hw.memsys.fault import Fault
from hw.memsys.image_layout import RegionNumber
from hw.memsys.result_formats import ResultKind
from tb.lib.timing import documented_latency

CONFIG = PRESETS["tiny"].replace({"noc.columns": 4, "noc.rows": 1, "icu.rays": 1 << 12,
                                   "icu.side_bits": 11})
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
    assert commands == [(64, 0, ALL & ~OWN), (64, 0, ALL & OWN)]
    assert words == [(0, 1, k) for k in range(8)]
    assert overs == [Fault.NONE]


def test_only_requested_results_are_written():
    commands, words, overs = load(ALL & ~OWN, seed=2)
    assert (len(commands), overs) == (1, [Fault.NONE])
    assert {is_all for _, is_all, _ in words} == {1}


@pytest.mark.parametrize("at", [0, 2])
def test_a_fault_ends_a_load(at):
    commands, _, overs = load(ALL, {at: Fault.POINTER}, seed=3)
    assert (len(commands), overs) == (at + 1, [Fault.POINTER])


@pytest.mark.parametrize("image", [1, 32, 4096 + 8, 1 << CONFIG.memory.address_bits, 1 << 63])
def test_an_image_is_at_an_address_that_is_a_multiple_of_64(image):
    assert load(ALL, image=image) == ([], [], [Fault.IMAGE])


def write(given, faults=(), *, seed=1):
    """What is requested of the clusters and of the DMA, in order, and how it ended."""
    dut, draw, requested, overs = ResultControl(config=CONFIG), random.Random(seed), [], []

    async def bench(ctx):
        for k in range(CLUSTERS):
            ctx.set(dut.sections[k], {"first_column": k, "end_column": k + 5, "first_row": 0, "end_row": 3})
        ctx.set(dut.results, {"hits": {"address": 0x100, "count": 60}, "sums": {"address": 0x900, "count": 21},
                              "columns": 9})
        ctx.set(dut.total, 77)
        ctx.set(dut.i.payload, given)
        ctx.set(dut.i.valid, 1)
        left = 0
        for cycle in range(3000):
            for stream in (dut.o_read_out, dut.o_sums, dut.o_command):
                ctx.set(stream.ready, draw.random() < 0.3)
            busy = left > 0
            left = max(0, left - 1)
            ctx.set(dut.i_done.valid, busy and left == 0)
            ctx.set(dut.i_done.payload.code, dict(faults).get(sum(one[0] == "command" for one in requested) - 1,
                                                              Fault.NONE))
            drops = ctx.get(dut.drops)
            ctx.set(dut.i_hit.valid, drops and draw.random() < 0.5)
            ctx.set(dut.i_hit.payload, draw.random() < 0.2)
            if ctx.get(dut.o_read_out.valid) and ctx.get(dut.o_read_out.ready):
                requested.append(("read out", ctx.get(dut.cluster), ctx.get(dut.o_read_out.payload)))
            if ctx.get(dut.o_sums.valid) and ctx.get(dut.o_sums.ready):
                requested.append(("sums", ctx.get(dut.o_sums.payload)))
            if ctx.get(dut.i_hit.valid) and ctx.get(dut.i_hit.payload):
                requested.append(("dropped", ctx.get(dut.cluster)))
            if ctx.get(dut.o_command.valid) and ctx.get(dut.o_command.ready):
                one = dut.o_command.payload
                kind = ResultKind(ctx.get(one.kind))
                requested.append(("command", kind.name, ctx.get(one.address), ctx.get(one["count"]),
                              ctx.get(one.section.first_column) if kind is ResultKind.HITS else ctx.get(one.total)))
                left = draw.randrange(2, 9)
            if ctx.get(dut.o_over.valid):
                overs.append(Fault(ctx.get(dut.o_over.payload.code)))
            await ctx.tick()
            if cycle == 0:
                ctx.set(dut.i.valid, 0)
                # The host may write other numbers from now on.
                ctx.set(dut.i.payload, {name: 1 - bit for name, bit in given.items()})
            if overs:
                assert not ctx.get(dut.busy)
                break

    run(dut, bench)
    return requested, overs


def hits(earlier):
    """All clusters' hits."""
    return [one for k in range(CLUSTERS)
            for one in (("read out", k, earlier), ("command", "HITS", 0x100, 60, k))]


SUMS = [("sums", 20), ("command", "SUMS", 0x900, 21, 77)]


@pytest.mark.parametrize("earlier", [0, 1])
def test_hits_and_sums(earlier):
    assert write({"hits": 1, "sums": 1, "earlier": earlier}) == ([*hits(earlier), *SUMS], [Fault.NONE])
    assert write({"hits": 1, "sums": 0, "earlier": earlier}, seed=2) == (hits(earlier), [Fault.NONE])


def test_sums_alone():
    dropped = [one for k in range(CLUSTERS) for one in (("read out", k, 0), ("dropped", k))]
    assert write({"hits": 0, "sums": 1, "earlier": 0}) == ([*dropped, *SUMS], [Fault.NONE])
    assert write({"hits": 0, "sums": 0, "earlier": 0}) == (dropped, [Fault.NONE])


def test_all_clusters_are_read_out_after_a_fault_and_the_first_one_is_reported():
    faults = {1: Fault.WRITE_REPLY, 3: Fault.NO_RECORD}
    assert write({"hits": 1, "sums": 1, "earlier": 0}, faults) == ([*hits(0), *SUMS], [Fault.WRITE_REPLY])


def cast(columns, rows, *, work=(), drains=40, final=30, ready=0.4, seed=1):
    """When what begins, in cycles from the cast; the end; tiles across; and whether the section is too large."""
    dut, draw, begun, ended = CastControl(config=CONFIG), random.Random(seed), {}, {}

    async def bench(ctx):
        ctx.set(dut.section, {"first_column": 3, "end_column": 3 + columns, "first_row": 1, "end_row": 1 + rows})
        ctx.set(dut.drained, 1)
        ctx.set(dut.i.valid, 1)
        for cycle in range(400):
            since = cycle - begun.get("traversal", cycle)
            ctx.set(dut.final, "traversal" in begun and since == final)
            ctx.set(dut.drained, "traversal" not in begun or since >= drains)
            ctx.set(dut.enters, since in [first for first, _ in work] and "traversal" in begun)
            ctx.set(dut.leaves, since in [last for _, last in work] and "traversal" in begun)
            for name in ("memory", "intersection", "traversal", "near"):
                stream = getattr(dut, f"o_{name}")
                ctx.set(stream.ready, draw.random() < ready)
                if ctx.get(stream.valid) and ctx.get(stream.ready):
                    assert name not in begun
                    begun[name] = cycle
            if ctx.get(dut.wrong):
                ended["wrong"] = 1
            await ctx.tick()
            ctx.set(dut.i.valid, 0)
            if not ctx.get(dut.busy):
                ended["after"], ended["cycles"] = since, ctx.get(dut.cycles)
                break
        ended["tiles"] = ctx.get(dut.tiles_across)
        for _ in range(5):
            await ctx.tick()
            assert not ctx.get(dut.busy)

    run(dut, bench)
    return begun, ended


@pytest.mark.parametrize("seed", range(4))
def test_traversal_begins_when_the_others_have(seed):
    begun, ended = cast(40, 10, seed=seed)
    assert len(begun) == 4
    assert max(begun["memory"], begun["intersection"]) < min(begun["traversal"], begun["near"])
    assert ended["tiles"] == 10
    assert "wrong" not in ended


def test_latency():
    begun, _ = cast(40, 10, ready=1)
    tiles_down = -(-10 >> CONFIG.icu.tile_bits)
    assert begun["memory"] == begun["intersection"] == documented_latency(CastControl, CONFIG, tiles_down=tiles_down)


@pytest.mark.parametrize(("work", "drains", "final", "last"), [
    ((), 40, 30, 40), ((), 20, 60, 60), (((10, 90), (12, 50)), 40, 30, 90), (((10, 20), (12, 33)), 30, 40, 40),
    # A patch enters in the cycle in which another one leaves.
    (((10, 12), (12, 60)), 20, 20, 60), (((10, 12), (12, 14), (14, 16)), 20, 30, 30)])
def test_a_cast_is_over_with_the_last_of_all(work, drains, final, last):
    _, ended = cast(40, 10, work=work, drains=drains, final=final)
    assert last < ended["after"] <= last + 5


@pytest.mark.parametrize("seed", range(8))
def test_patches_enter_and_leave_at_random(seed):
    draw = random.Random(seed)
    enters, leaves = sorted(draw.sample(range(1, 60), 24)), []
    for first in enters:
        leaves.append(next(cycle for cycle in range(first + draw.randrange(1, 30), 200) if cycle not in leaves))
    drains, final = draw.randrange(20, 100), draw.randrange(20, 100)
    _, ended = cast(40, 10, work=tuple(zip(enters, leaves, strict=True)), drains=drains, final=final, seed=seed)
    last = max(*leaves, drains, final)
    assert last < ended["after"] <= last + 5


@pytest.mark.parametrize(("columns", "rows", "fits"), [
    (64, 64, True), (64, 65, False), (65, 64, False), (1, 1, True), (1024, 4, True), (1024, 5, False), (61, 61, True),
    # 255, 256 and 257 tiles of 4 x 4 rays, the last of them cut or whole; the ray memory has 256.
    (60, 68, True), (1020, 1, True), (1021, 1, True), (1024, 1, True), (1025, 1, False), (1028, 4, False),
    (1, 1024, True), (1, 1025, False), (2048, 2048, False)])
def test_a_section_must_fit_the_ray_memory(columns, rows, fits):
    begun, ended = cast(columns, rows)
    assert ("wrong" not in ended) == fits
    assert bool(begun) == fits
