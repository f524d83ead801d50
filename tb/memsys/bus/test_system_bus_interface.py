"""Requests of several clusters for cells and patches: the hits of golden's caches, and replies in order."""

import pytest

from hw.lib.payload import unpack
from hw.memsys.bus.cache_policy import CachePolicy
from hw.memsys.bus.system_bus_interface import SystemBusInterface
from hw.memsys.patches.path_formats import BEATS, PathFormats, RequestKind
from tb.lib.bench import Bench, Case, Vectors
from tb.lib.configurations import config_of
from tb.lib.responder import Responder, responder
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.timing import documented_latency
from tb.memsys.bus_scene import BusScene

LINES = 8
CHANGES = {"memsys.reply_ids": 4, "memsys.cache_fetches": 4, "icu.patch_bits": 8, "memsys.cell_lines": LINES,
           "memsys.patch_lines": LINES, "memsys.cache_ways": 2, "memsys.lfu_lines": 4, "memsys.lfu_count_bits": 3}
CONFIG = config_of(CHANGES)
SCENE, BASE = BusScene(CONFIG), 0x2000
PORTS = {"scene": SCENE.counts, "bases": {name: BASE + offset for name, offset in SCENE.bases.items()}}
# In each kind some keys that cannot be read.
FAILED = {RequestKind.CELL: (2, 3), RequestKind.PATCH: (1, 4)}
# Two entries of a word.
FAILED_ENTRIES = {20, 21}
UNREADABLE = {*(SCENE.bases["cells"] + 8 * cell for cell in FAILED[RequestKind.CELL]),
              SCENE.bases["lists"] + 4 * min(FAILED_ENTRIES),
              *(SCENE.bases["patches"] + 64 * patch + 8 * patch + 8 for patch in FAILED[RequestKind.PATCH])}


def beats(request, unreadable):
    """Memory's reply to a request."""
    positions = [request["address"] - BASE + 8 * number for number in range(request["length"] + 1)]
    return [{"data": int.from_bytes(SCENE.image[position:position + 8], "little"), "tag": request["tag"],
             "last": position == positions[-1], "error": position in unreadable} for position in positions]


def bus_requests(requests):
    return [{"source": cluster, "item": {"kind": kind.value, "key": key}} for cluster, kind, key in requests]


class TestSystemBusInterface(Bench):
    component, changes, formula, idle_limit = SystemBusInterface, CHANGES, {}, 60
    simulators = (pytest.param("icarus", marks=[pytest.mark.icarus, pytest.mark.nightly]),)
    cases = {policy.name: Case(lambda config, policy=policy: vectors(policy, 90, seed=9), timed=False)
             for policy in CachePolicy} | {
        "errors": Case(lambda config: vectors(CachePolicy.LRU, 90, seed=9, fails=True), timed=False)}
    variants, cycles = ({},), 100_000

    def drawn(self, config, seed):
        return vectors(list(CachePolicy)[seed % len(CachePolicy)], 40, seed=seed, fails=seed % 2)

    def check(self, given, came):
        super().check(given, came)
        cell_beat = PathFormats(CONFIG).cell_beat
        for beat in self.values("o_reply__0", came):
            assert not (beat["error"] and unpack(cell_beat, beat["data"])["is_id"]), "an error has no id"

    @responder("o_request", "i_reply", after=(0, 12))
    def memory(self, request):
        return beats(request, self.now.about)


def is_unreadable(kind, key):
    """Whether memory cannot read a part of a cell or a patch."""
    if kind is RequestKind.PATCH:
        return key in FAILED[kind]
    return key & (1 << PathFormats(CONFIG).cell_bits) - 1 in FAILED[kind] or bool(
        FAILED_ENTRIES & {*SCENE.entries(key)})


def vectors(policy, count, *, seed, fails=False):
    """Requests from empty caches on; memory cannot read all bytes if it ``fails``."""
    requests, expected = SCENE.requests(count, seed), {}
    if not fails:
        # An error empties the cache.
        requests = [one for one in requests if not SCENE.reply(one[1], 0, one[2], 0)[0]["error"]]
    for kind in RequestKind:
        mine = [(cluster, key) for cluster, which, key in requests if which is kind]
        hits, replies, known = SCENE.hits(mine, policy.name.lower(), LINES), [], True
        for (cluster, key), hit in zip(mine, hits, strict=True):
            reply = SCENE.reply(kind, cluster, key, hit, failed=bool(fails) and is_unreadable(kind, key))
            replies += reply if known else [{**beat, "hit": None} for beat in reply]
            # After the first error lines are emptied at a time of the cache's own.
            known = known and not reply[0]["error"]
        expected[f"o_reply__{kind.value}"] = replies
    return Vectors(first={"i_invalidate": [policy.value]}, inputs={"i_request": bus_requests(requests)},
                   expected=expected, ports=PORTS, about=UNREADABLE if fails else ())


def test_no_reply_waits_for_a_request():
    """Memory accepts so many requests, and no other one before it has answered them."""
    bench = ScheduleBench(SystemBusInterface(config=CONFIG), idle_limit=60)
    memory = Responder("o_request", "i_reply", lambda request: beats(request, ()), after=12)
    requests = [(0, kind, key) for key in range(8) for kind in RequestKind]
    for accepted in range(1, 3 * CONFIG.memsys.cache_fetches):
        came = bench.run(Schedule(
            first={"i_invalidate": [CachePolicy.LRU.value]}, stalls={"o_request": [0] * accepted + [300]},
            items={"i_request": [(0, request) for request in bus_requests(requests)]}), memory, **PORTS)
        answers = sum(request["length"] + 1 for request in came["o_request"][:accepted])
        assert bench.cycles["i_reply"][answers - 1] < bench.cycles["o_request"][accepted], f"{accepted} requests"


def test_hits_come_beat_after_beat():
    memory = Responder("o_request", "i_reply", lambda request: beats(request, ()), after=12)
    bench = ScheduleBench(SystemBusInterface(config=CONFIG), idle_limit=60)

    def cycles(requests):
        bench.run(Schedule(first={"i_invalidate": [CachePolicy.LRU.value]}, items={
            "i_request": [(0, request) for request in bus_requests(requests)]}), memory, **PORTS)
        return bench.cycles

    few = [(0, RequestKind.PATCH, key) for key in (1, 2)]
    came = cycles(few + [(1, RequestKind.PATCH, 1 + k % 2) for k in range(12)])["o_reply__1"][len(few) * BEATS:]
    assert came == list(range(came[0], came[0] + 12 * BEATS))
    alone = cycles([few[0], *[(0, RequestKind.CELL, 0)] * 30, few[0]])
    assert alone["o_reply__1"][BEATS] - alone["i_request"][-1] == documented_latency(SystemBusInterface, CONFIG)
