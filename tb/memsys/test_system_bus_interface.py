# amaranth: UnusedElaboratable=no
"""Requests of several clusters for cells and patches: the hits of golden's caches, and replies in order."""

import random
from collections import deque

import pytest
from amaranth.sim import Simulator

from golden.config import PRESETS
from hw.memsys.cache_policy import CachePolicy
from hw.memsys.path_formats import BEATS, RequestKind
from hw.memsys.system_bus_interface import SystemBusInterface
from tb.lib.timing import documented_latency
from tb.memsys.bus_scene import BusScene

CONFIG = PRESETS["tiny"].replace({"memsys.reply_ids": 4, "memsys.cache_fetches": 4, "icu.patch_bits": 8,
                                  "memsys.cell_lines": 8, "memsys.patch_lines": 8, "memsys.cache_ways": 2,
                                  "memsys.lfu_lines": 4, "memsys.lfu_count_bits": 3})
BASE = 0x2000


class Bench:
    """The interface, a scene in memory, and what comes."""

    def __init__(self, *, policies=tuple(CachePolicy), latency=12, slow=True):
        self.dut = SystemBusInterface(config=CONFIG, policies=policies)
        self.random, self._latency, self._slow = random.Random(3), latency, slow
        self.scene = BusScene(CONFIG)
        self.replies, self.cycles, self.asked = ([], []), ([], []), []

    def run(self, policy, requests):
        """Replies, beat by beat, to requests of (cluster, kind, key)."""
        dut = self.dut

        async def drive(ctx):
            ctx.set(dut.scene, self.scene.counts)
            ctx.set(dut.bases, {name: BASE + offset for name, offset in self.scene.bases.items()})
            ctx.set(dut.i_invalidate.payload, policy)
            ctx.set(dut.i_invalidate.valid, 1)
            await ctx.tick().until(dut.i_invalidate.ready)
            ctx.set(dut.i_invalidate.valid, 0)
            left, beats, cycle = deque(requests), deque(), 0
            expected = [sum(kind is which for _, kind, _ in requests) for which in RequestKind]
            while any(sum(beat["last"] for beat in came) < count
                      for came, count in zip(self.replies, expected, strict=True)):
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
                            "data": int.from_bytes(self.scene.image[at:at + 8], "little"), "tag": asked.tag,
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


@pytest.mark.parametrize("policy", [CachePolicy.LRU, *(pytest.param(policy, marks=pytest.mark.nightly) for policy in (
    CachePolicy.DIRECT, CachePolicy.LFU))])
def test_hits_are_goldens_access_by_access(policy):
    requests = BusScene(CONFIG).requests(90, seed=9)
    bench = Bench().run(policy, requests)
    for kind in RequestKind:
        mine = [(cluster, key) for cluster, which, key in requests if which is kind]
        bench.scene.check(kind, mine, bench.scene.hits(mine, policy.name.lower(), 8), bench.replies[kind.value])


def test_hits_come_beat_after_beat():
    few = [(0, RequestKind.PATCH, key) for key in (1, 2)]
    bench = Bench(slow=False).run(CachePolicy.LRU, few + [(1, RequestKind.PATCH, 1 + k % 2) for k in range(12)])
    cycles, number = bench.cycles[1], len(few) * BEATS
    assert cycles[number:] == list(range(cycles[number], cycles[number] + 12 * BEATS))
    alone = Bench(slow=False).run(CachePolicy.LRU, [(0, RequestKind.PATCH, 1), *[(0, RequestKind.CELL, 0)] * 30,
                                                    (0, RequestKind.PATCH, 1)])
    latency = documented_latency(SystemBusInterface, CONFIG)
    assert alone.cycles[1][BEATS] - alone.asked[-1] == latency
