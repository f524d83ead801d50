# amaranth: UnusedElaboratable=no
"""Requests of several clusters for cells and patches: the hits of golden's caches, and replies in order."""

import random
from collections import deque
from itertools import pairwise

import numpy as np
import pytest
from amaranth.sim import Simulator

from golden.config import PRESETS
from golden.memsys.cache import Cache
from hw.memsys.cache_policy import CachePolicy
from hw.memsys.path_formats import BEATS, PathFormats, RequestKind
from hw.memsys.system_bus_interface import SystemBusInterface
from tb.lib.payload import pack
from tb.lib.timing import documented_latency
from tb.memsys.memory_path import scene_image

CONFIG = PRESETS["tiny"].replace({"memsys.reply_ids": 4, "memsys.cache_fetches": 4, "icu.patch_bits": 8,
                                  "memsys.cell_lines": 8, "memsys.patch_lines": 8, "memsys.cache_ways": 2,
                                  "memsys.lfu_lines": 4, "memsys.lfu_count_bits": 3})
FORMATS, BASE, COUNT = PathFormats(CONFIG), 0x2000, 24


class Bench:
    """The interface, a scene in memory, and what comes."""

    def __init__(self, *, policies=tuple(CachePolicy), latency=12, slow=True):
        self.dut = SystemBusInterface(config=CONFIG, policies=policies)
        self.random, self._latency, self._slow = random.Random(3), latency, slow
        draw = random.Random(4)
        self.cells = [(4 * k, draw.randrange(1, 9)) for k in range(20)]
        self.lists = [draw.randrange(COUNT) for _ in range(90)]
        self.vertices = [[[draw.randrange(1 << 24) for _ in range(3)] for _ in range(4)] for _ in range(COUNT)]
        self.image, self.bases = scene_image([a for a, _ in self.cells], [b for _, b in self.cells], self.lists,
                                             self.vertices, [0] * COUNT)
        self.replies, self.cycles, self.asked = ([], []), ([], []), []

    def run(self, policy, requests):
        """Replies, beat by beat, to requests of (cluster, kind, key)."""
        dut = self.dut

        async def drive(ctx):
            ctx.set(dut.scene, {"cells": len(self.cells), "lists": len(self.lists), "patches": COUNT})
            ctx.set(dut.bases, {name: BASE + offset for name, offset in self.bases.items()})
            ctx.set(dut.i_invalidate.payload, policy)
            ctx.set(dut.i_invalidate.valid, 1)
            await ctx.tick().until(dut.i_invalidate.ready)
            ctx.set(dut.i_invalidate.valid, 0)
            left, beats, cycle = deque(requests), deque(), 0
            wanted = [sum(kind is which for _, kind, _ in requests) for which in RequestKind]
            while any(sum(beat["last"] for beat in came) < count
                      for came, count in zip(self.replies, wanted, strict=True)):
                cycle += 1
                assert cycle < 6000, "not all requests are answered"
                ctx.set(dut.i_request.valid, bool(left))
                if left:
                    cluster, kind, key = left[0]
                    ctx.set(dut.i_request.payload, {"source": cluster, "item": {"kind": kind, "key": key}})
                for reply in dut.o_reply:
                    ctx.set(reply.ready, not self._slow or self.random.random() < 0.7)
                ctx.set(dut.o_request.ready, 1)
                shows = bool(beats and beats[0][0] <= cycle)
                ctx.set(dut.i_reply.valid, shows)
                if shows:
                    ctx.set(dut.i_reply.payload, beats[0][1])
                if ctx.get(dut.i_request.valid & dut.i_request.ready):
                    left.popleft()
                    self.asked.append(cycle)
                if ctx.get(dut.i_reply.valid & dut.i_reply.ready):
                    beats.popleft()
                if ctx.get(dut.o_request.valid):
                    asked = ctx.get(dut.o_request.payload)
                    for k in range(asked.length + 1):
                        at = asked.address - BASE + 8 * k
                        beats.append((cycle + self._latency, {
                            "data": int.from_bytes(self.image[at:at + 8], "little"), "tag": asked.tag,
                            "last": k == asked.length, "error": 0}))
                for reply, came, cycles in zip(dut.o_reply, self.replies, self.cycles, strict=True):
                    if ctx.get(reply.valid & reply.ready):
                        beat = ctx.get(reply.payload)
                        came.append({"cluster": beat.cluster, "last": beat.last, "hit": beat.hit, "data": beat.data,
                                     "error": beat.error})
                        cycles.append(cycle)
                await ctx.tick()

        simulator = Simulator(dut)
        simulator.add_clock(1e-8)
        simulator.add_testbench(drive)
        simulator.run()
        return self


def grouped(beats):
    """Replies of their beats."""
    ends = [k + 1 for k, beat in enumerate(beats) if beat["last"]]
    return [beats[a:b] for a, b in pairwise([0, *ends])]


def key_of(kind, draw):
    if kind is RequestKind.PATCH:
        return draw.choice([draw.randrange(6), draw.randrange(COUNT)])
    return draw.choice([draw.randrange(4), draw.randrange(20)]) | draw.randrange(2) * (1 << FORMATS.cell_bits)


@pytest.mark.parametrize("policy", [CachePolicy.LRU, *(pytest.param(policy, marks=pytest.mark.nightly) for policy in (
    CachePolicy.DIRECT, CachePolicy.LFU))])
def test_hits_are_goldens_access_by_access(policy):
    draw = random.Random(9)
    requests = [(draw.randrange(2), kind, key_of(kind, draw)) for kind in (draw.choice(list(RequestKind))
                                                                          for _ in range(90))]
    bench = Bench().run(policy, requests)
    config = CONFIG.replace({"memsys.cache_policy": policy.name.lower()})
    for kind in RequestKind:
        mine = [(cluster, key) for cluster, which, key in requests if which is kind]
        golden = Cache.of(config.memsys, lines=8)
        hit, _, _ = golden.access(np.array([key for _, key in mine]))
        replies = grouped(bench.replies[kind.value])
        for (cluster, key), held, beats in zip(mine, hit, replies, strict=True):
            assert {beat["cluster"] for beat in beats} == {cluster}
            assert {beat["hit"] for beat in beats} == {int(held)}, (kind, key)
            data = [beat["data"] for beat in beats]
            if kind is RequestKind.PATCH:
                assert data == [key, *(sum(part << 24 * axis for axis, part in enumerate(one))
                                       for one in bench.vertices[key])]
                continue
            part, cell = divmod(key, 1 << FORMATS.cell_bits)
            pointer, count = bench.cells[cell]
            entries = bench.lists[pointer:pointer + count][4 * part:4 * part + 4]
            # A part behind the list's end is an error, or empty if the one before it was full.
            assert any(beat["error"] for beat in beats) == (4 * part > count)
            assert data[:len(entries)] == [pack(FORMATS.cell_beat, {
                "number": entry, "is_id": 1, "more": 4 * part + 4 < count}) for entry in entries]
            assert len(beats) == max(1, len(entries))


def test_hits_come_beat_after_beat():
    few = [(0, RequestKind.PATCH, key) for key in (1, 2)]
    bench = Bench(slow=False).run(CachePolicy.LRU, few + [(1, RequestKind.PATCH, 1 + k % 2) for k in range(12)])
    cycles, number = bench.cycles[1], len(few) * BEATS
    assert cycles[number:] == list(range(cycles[number], cycles[number] + 12 * BEATS))
    alone = Bench(slow=False).run(CachePolicy.LRU, [(0, RequestKind.PATCH, 1), *[(0, RequestKind.CELL, 0)] * 30,
                                                    (0, RequestKind.PATCH, 1)])
    latency = documented_latency(SystemBusInterface, CONFIG)
    assert alone.cycles[1][BEATS] - alone.asked[-1] == latency
