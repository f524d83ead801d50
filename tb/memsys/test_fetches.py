"""What the caches fetch: lists in parts and patches, from a memory that is late; malformed tables and errors."""

import random
from collections import deque

import pytest
from amaranth.sim import Simulator

from golden.config import PRESETS
from hw.memsys.cell_fetch import CellFetch
from hw.memsys.patch_fetch import PatchFetch
from hw.memsys.path_formats import BEATS, PathFormats
from tb.lib.payload import pack, unpack
from tb.lib.timing import documented_latency
from tb.memsys.memory_path import scene_image

CONFIG = PRESETS["tiny"].replace({"memsys.reply_ids": 4, "memsys.cache_fetches": 4, "icu.patch_bits": 8})
FORMATS, BASE, NONE = PathFormats(CONFIG), 0x1240, (1 << 32) - 1


def fetch(dut, keys, image, ports, *, ids, latency, fails=(), seed=1):
    """The records of some keys as they are put together, and when requests and fills came."""
    draw, came, times = random.Random(seed), {}, {"in": [], "request": [], "reply": [], "fill": [], "stream": []}
    streams = list(zip(dut.o_request, dut.i_reply, strict=True)) if ids == "array" else [(dut.o_request, dut.i_reply)]
    left, free, records = deque(enumerate(keys)), list(range(CONFIG.memsys.cache_fetches)), {}
    fill_shape = dut.signature.members["o"].signature.members["payload"].shape

    async def drive(ctx):
        for name, value in ports.items():
            ctx.set(getattr(dut, name), value)
        replies, busy, cycle = [deque() for _ in streams], {}, 0
        while left or busy:
            cycle += 1
            assert cycle < 4000, "the fetches do not end"
            offers = bool(left and free)
            ctx.set(dut.i.valid, offers)
            if offers:
                ctx.set(dut.i.payload, {"slot": free[0], "key": left[0][1]})
            for (request, reply), waiting in zip(streams, replies, strict=True):
                ctx.set(request.ready, latency == 1 or draw.random() < 0.7)
                shows = bool(waiting and waiting[0][0] <= cycle)
                ctx.set(reply.valid, shows)
                if shows:
                    ctx.set(reply.payload, waiting[0][1])
            if ctx.get(dut.i.valid & dut.i.ready):
                busy[free.pop(0)] = left.popleft()[0]
                times["in"].append(cycle)
            for number, ((request, reply), waiting) in enumerate(zip(streams, replies, strict=True)):
                if ctx.get(reply.valid & reply.ready):
                    waiting.popleft()
                    times["reply"].append(cycle)
                if ctx.get(request.valid & request.ready):
                    times["request"].append(cycle)
                    times["stream"].append(number)
                    address, length = ctx.get(request.payload.address), ctx.get(request.payload.length)
                    for k in range(length + 1):
                        at = address - BASE + 8 * k
                        assert 0 <= at <= len(image) - 8, f"{address:#x} is outside the image"
                        waiting.append((cycle + draw.randint(1, latency), {
                            "data": int.from_bytes(image[at:at + 8], "little"), "last": k == length,
                            "error": at in fails}))
            if ctx.get(dut.o.valid):
                times["fill"].append(cycle)
                fill = unpack(fill_shape, ctx.get(dut.o.payload.as_value()))
                beats = records.setdefault(busy[fill["slot"]], [])
                assert fill["beat"] == len(beats), "beats of a slot come in their order"
                beats.append((fill["data"], fill["error"]))
                if fill["beat"] == (CONFIG.memsys.reply_ids if ids == "array" else BEATS) - 1:
                    came[busy.pop(fill["slot"])] = records.pop(busy.get(fill["slot"]), None) or beats
                    free.append(fill["slot"])
            await ctx.tick()

    simulator = Simulator(dut)
    simulator.add_clock(1e-8)
    simulator.add_testbench(drive)
    simulator.run()
    return [came[number] for number in range(len(keys))], times


def patches(draw, count):
    width = CONFIG.numbers.scene.width
    return [[[draw.randrange(1 << width) for _ in range(3)] for _ in range(4)] for _ in range(count)]


@pytest.mark.parametrize("latency", [1, 40])
def test_patches(latency):
    draw, count = random.Random(5), 20
    vertices, surface = patches(draw, count), [draw.randrange(-3, 1 << 20) for _ in range(count)]
    image, bases = scene_image([], [], [], vertices, surface)
    image = bytearray(image)
    # Patch 7 says that it is patch 8; of patch 9 a beat cannot be read.
    image[bases["patches"] + 7 * 64] = 8
    keys = [3, 19, 0, 7, 20, 9, 255, 4, 3, 1, 2, 5]
    dut = PatchFetch(config=CONFIG)
    came, times = fetch(dut, keys, bytes(image), {"base": BASE + bases["patches"], "count": count}, ids="one",
                        latency=latency, fails=[bases["patches"] + 9 * 64 + 32])
    bits = CONFIG.numbers.scene.width
    for key, beats in zip(keys, came, strict=True):
        error = any(bad for _, bad in beats)
        assert error == (key in (7, 9) or key >= count), key
        if not error:
            head = pack(FORMATS.patch_head, {"patch": key, "surface": surface[key]})
            assert [data for data, _ in beats] == [
                head, *(sum(part << bits * axis for axis, part in enumerate(one)) for one in vertices[key])]
    assert len(times["request"]) == sum(key < count for key in keys)
    if latency == 1:
        assert times["request"][0] - times["in"][0] == dut.latency == documented_latency(PatchFetch, CONFIG)


@pytest.mark.parametrize("latency", [1, 40])
def test_parts_of_lists(latency):
    draw = random.Random(6)
    lists = [draw.randrange(200) for _ in range(60)]
    lists[21], lists[30] = 200, NONE
    cells = [(0, 0), (60, 0), (0, 4), (1, 4), (3, 1), (59, 1), (2, 9), (20, 12), (0, 61), (61, 0), (58, 3), (NONE, 2),
             (3, NONE), (30, 1), (7, 5), (0, 60)]
    # Of every other one the only word cannot be read; its reply may wait while the beats before it are filled up.
    cells += [(2 if k % 2 else 50 + k, 1) for k in range(8)]
    image, bases = scene_image([a & NONE for a, _ in cells], [b for _, b in cells], lists, patches(draw, 1), [0])
    keys = [{"cell": 3, "part": 0}]
    keys += [{"cell": cell, "part": part} for cell, (pointer, count) in enumerate(cells) for part in range(
        max(1, -(-count // 4)) if pointer + count <= 60 else 1)]
    keys += [{"cell": len(cells), "part": 0}, {"cell": 2, "part": 3}, {"cell": 6, "part": 200}]
    fails = [bases["cells"] + 8 * 4, (bases["lists"] + 4 * 3) & ~7]
    dut = CellFetch(config=CONFIG)
    scene = {"cells": len(cells), "lists": len(lists), "patches": 200}
    came, times = fetch(dut, keys, image, {"cells_base": BASE + bases["cells"], "lists_base": BASE + bases["lists"],
                                           "scene": scene}, ids="array", latency=latency, fails=fails)
    for key, beats in zip(keys, came, strict=True):
        cell, part = key["cell"], key["part"]
        pointer, count = cells[cell] if cell < len(cells) else (0, 0)
        first, end = pointer + 4 * part, min(pointer + count, pointer + 4 * part + 4)
        wrong = cell >= len(cells) or pointer + count > len(lists) or 4 * part > count or cell == 4
        read = not wrong and any((bases["lists"] + 4 * entry) & ~7 in fails for entry in range(first, end))
        assert any(bad for _, bad in beats) == (wrong or read), key
        if wrong:
            assert not any(data["is_id"] for data, _ in beats)
        elif not read:
            numbers = [lists[entry] if lists[entry] < 200 else 256 for entry in range(first, end)]
            assert [data["number"] for data, _ in beats if data["is_id"]] == numbers
            assert [data["is_id"] for data, _ in beats] == [k < len(numbers) for k in range(4)]
            assert all(data["more"] == (end < pointer + count) for data, _ in beats)
    assert times["stream"].count(0) == sum(key["cell"] < len(cells) for key in keys), "a record of each cell there is"
    if latency == 1:
        assert times["request"][0] - times["in"][0] == dut.latency == documented_latency(CellFetch, CONFIG)
        assert times["reply"][0] + 5 in times["request"]


def test_a_list_of_more_parts_than_can_be_named_ends_with_an_error():
    """Otherwise the part behind the last one would be the first one again."""
    parts = 1 << FORMATS.part_bits
    count = 4 * parts
    image, bases = scene_image([0, 0], [count, count + 1], [0] * (count + 1), patches(random.Random(1), 1), [0])
    keys = [{"cell": cell, "part": part} for cell in range(2) for part in (parts - 2, parts - 1)]
    came, _ = fetch(CellFetch(config=CONFIG), keys, image, {
        "cells_base": BASE + bases["cells"], "lists_base": BASE + bases["lists"],
        "scene": {"cells": 2, "lists": count + 1, "patches": 1}}, ids="array", latency=1)
    assert [{(data["more"], bad) for data, bad in beats} for beats in came] == [
        {(1, 0)}, {(0, 0)}, {(1, 0)}, {(0, 1)}]
