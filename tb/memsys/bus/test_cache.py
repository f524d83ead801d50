import random
import re
from collections import Counter

import cocotb
import numpy as np
import pytest
from cocotb.triggers import ClockCycles, RisingEdge

from golden.engine.memsys.bus.cache import Cache as GoldenCache
from golden.engine.memsys.bus.cache_policy import CachePolicy as GoldenPolicy
from hw.lib.payload import pack, unpack
from hw.memsys.bus.cache import Cache
from hw.memsys.bus.cache_policy import CachePolicy
from tb.lib.clocking import reset, start
from tb.lib.configurations import config_of
from tb.lib.no_x import assert_known
from tb.lib.responder import Responder
from tb.lib.runner import SIMULATORS, options, simulate
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.seed import SEED
from tb.lib.stall_patterns import STALL_PAIRS, STALLS
from tb.lib.stream import Monitor, Sink, Source
from tb.lib.timing import documented_latency

STREAMS = ["i_invalidate", "i", "o", "o_fetch"]
# Both a record of one beat and one of several, few fetches and many; tags run out in the middle of a testbench.
SIZES = {
    "small": {"lines": 8, "beats": 1, "key": 6, "tag": 3, "memsys.cache_ways": 2, "memsys.lfu_lines": 4,
              "memsys.lfu_count_bits": 2, "memsys.cache_generation_bits": 2, "memsys.cache_fetches": 2},
    "large": {"lines": 32, "beats": 3, "key": 10, "tag": 8, "memsys.cache_ways": 4, "memsys.lfu_lines": 16,
              "memsys.lfu_count_bits": 4, "memsys.cache_generation_bits": 3, "memsys.cache_fetches": 8},
}
WIDTH = 20


def make(size):
    config = config_of({path: value for path, value in size.items() if "." in path})
    return Cache(WIDTH, beats=size["beats"], config=config, lines=size["lines"], key=size["key"], tag=size["tag"])


def record_of(key, epoch, beats):
    """What memory holds: other data after each invalidation."""
    return [(key * 40503 + beat * 9973 + epoch * 6151) % (1 << WIDTH) for beat in range(beats)]


class Store:
    """The memory: answers fetches after a while, in their order or in any, beats of several of them mixed.

    Parameters
    ----------
    delay
        From a random generator to the cycles until the first beat.
    shuffles
        Which of the records that are due goes on is drawn for each beat.
    """

    def __init__(self, bench, *, delay, shuffles, stalls="none"):
        self._bench, self._delay, self._shuffles = bench, delay, shuffles
        self._random, self._due = random.Random(bench.seed), []
        self.fetches = []
        self._now = 0
        dut = bench.dut
        self._edge, self._valid, self._payload = RisingEdge(dut.clk), dut.i_fill__valid, dut.i_fill__payload
        self._valid.value = 0
        shape = bench.cache.signature.members["o_fetch"].signature.members["payload"].shape
        self._fetch = Sink(dut, "o_fetch", stalls=STALLS[stalls](bench.seed + 7),
                           seen=lambda bits: self._request_beats(unpack(shape, bits)))
        self._fill = bench.cache.signature.members["i_fill"].signature.members["payload"].shape
        self._task = cocotb.start_soon(self._run())

    def _request_beats(self, fetch):
        assert all(fetch["slot"] != slot for _, slot, *_ in self._due), "a slot must be free before it is used again"
        self.fetches.append(fetch["key"])
        self._due.append([self._now + self._delay(self._random), fetch["slot"], fetch["key"], 0])

    async def _run(self):
        beats = self._bench.size["beats"]
        while True:
            due = [one for one in self._due if one[0] <= self._now]
            self._valid.value = int(bool(due) and (self._shuffles or due[0] is self._due[0]))
            if due and (self._shuffles or due[0] is self._due[0]):
                one = self._random.choice(due) if self._shuffles else due[0]
                _, slot, key, beat = one
                data = record_of(key, self._bench.epoch, beats)[beat]
                self._payload.value = pack(self._fill, {"slot": slot, "beat": beat, "data": data, "error": 0})
                one[3] += 1
                if one[3] == beats:
                    self._due.remove(one)
            await self._edge
            self._now += 1

    def stop(self):
        self._task.cancel()
        self._fetch.stop()
        self._valid.value = 0


class Bench:
    """A cache, its golden control, and what has been requested and answered."""

    def __init__(self, dut):
        self.dut, self.seed, self.size = dut, options()["seed"], options()["size"]
        self.cache, self.epoch = make(self.size), 0
        self._i = self.cache.signature.members["i"].signature.members["payload"].shape
        self._o = self.cache.signature.members["o"].signature.members["payload"].shape
        self.taken = Monitor(dut, "i")

    def golden(self, policy):
        memsys = {path.partition(".")[2]: value for path, value in self.size.items() if "." in path}
        return GoldenCache(GoldenPolicy[policy], lines=self.size["lines"], ways=memsys["cache_ways"],
                           lfu_lines=memsys["lfu_lines"], lfu_count_bits=memsys["lfu_count_bits"])

    async def invalidate(self, policy):
        await Source(self.dut, "i_invalidate").send([CachePolicy[policy].value])
        self.epoch += 1

    def requests(self, keys):
        return [pack(self._i, {"tag": number % (1 << self.size["tag"]), "key": int(key)})
                for number, key in enumerate(keys)]

    def expected(self, keys, golden, first=0, epoch=None):
        """Answers to requests of an epoch, and of each whether it is a hit."""
        epoch = self.epoch if epoch is None else epoch
        hit, line, _ = golden.access(keys)
        return [pack(self._o, {
            "tag": (first + number) % (1 << self.size["tag"]), "record": record_of(int(key), epoch, self.size["beats"]),
            "line": int(address), "hit": bool(held), "error": 0})
            for number, (key, address, held) in enumerate(zip(keys, line, hit, strict=True))], hit

    async def finish(self, sink, expected):
        for _ in range(20_000):
            if len(sink.items) >= len(expected):
                break
            await RisingEdge(self.dut.clk)
        await ClockCycles(self.dut.clk, 30)
        for number, (got, required) in enumerate(zip(sink.items, expected, strict=False)):
            assert got == required, f"answer {number}: {unpack(self._o, got)}, not {unpack(self._o, required)}"
        assert len(sink.items) == len(expected)

    async def run(self, keys, policy, *, source="none", sink="none", store=None):
        """An empty cache under a policy serves a string; the answers' sink and the golden cache."""
        await self.invalidate(policy)
        golden = self.golden(policy)
        expected, hit = self.expected(keys, golden)
        sink = Sink(self.dut, "o", stalls=STALLS[sink](self.seed + 1))
        self.taken.items.clear()
        self.taken.cycles.clear()
        before = len(store.fetches)
        await Source(self.dut, "i", stalls=STALLS[source](self.seed)).send(self.requests(keys))
        await self.finish(sink, expected)
        assert store.fetches[before:] == [int(key) for key, held in zip(keys, hit, strict=True) if not held]
        assert (int(self.dut.hits.value), int(self.dut.misses.value)) == (golden.hits, golden.misses)
        sink.stop()
        return sink, hit

    def keys(self, count, seed):
        """Keys that come again soon, and later, in few sets and in many."""
        draw, lines = random.Random(self.seed * 1000 + seed), self.size["lines"]
        most = 1 << self.size["key"]
        return np.array([draw.choice([draw.randrange(lines // 2), draw.randrange(3) * lines % most,
                                      draw.randrange(2 * lines) % most, draw.randrange(most)]) for _ in range(count)])


@cocotb.test()
async def access_by_access(dut):
    """Hits, lines and records are golden's under every pair of stall patterns, all policies in turn."""
    await start(dut, cycles=200_000)
    bench = Bench(dut)
    dut.i__valid.value = dut.i_invalidate__valid.value = dut.o__ready.value = 0
    store = Store(bench, delay=lambda draw: draw.randrange(1, 12), shuffles=True, stalls="random")
    await ClockCycles(dut.clk, 2)
    assert_known(dut, STREAMS)
    assert not int(dut.i__ready.value), "nothing is taken before the first invalidation"
    policies = [policy.name for policy in CachePolicy]
    for number, (source, sink) in enumerate(STALL_PAIRS):
        await bench.run(bench.keys(40, number), policies[number % len(policies)], source=source, sink=sink, store=store)


@cocotb.test()
async def records_come_in_any_order(dut):
    """Whatever memory takes: at once, late, in any order, beats of different records mixed."""
    await start(dut, cycles=200_000)
    bench = Bench(dut)
    for number, policy in enumerate(CachePolicy):
        for delay, shuffles in ((lambda draw: 1, False), (lambda draw: 50, False), (lambda draw: 1, True),
                                (lambda draw: draw.randrange(1, 80), True)):
            store = Store(bench, delay=delay, shuffles=shuffles)
            await bench.run(bench.keys(100, 50 + number), policy.name, store=store)
            store.stop()


@cocotb.test()
async def one_hit_per_cycle(dut):
    """Hits come without a gap after the latency, however they follow each other."""
    await start(dut, cycles=50_000)
    bench = Bench(dut)
    store = Store(bench, delay=lambda draw: 1, shuffles=False)
    for policy in CachePolicy:
        few = np.arange(1, 4)
        keys = np.concatenate([few, few[bench.keys(120, 9) % 3]])
        await bench.run(few, policy.name, store=store)
        sink = Sink(dut, "o")
        bench.taken.cycles.clear()
        await Source(dut, "i").send(bench.requests(keys))
        while len(sink.items) < len(keys):
            await RisingEdge(dut.clk)
        assert int(dut.hits.value) == len(keys)
        for cycles in (bench.taken.cycles, sink.cycles):
            assert cycles == list(range(cycles[0], cycles[0] + len(keys)))
        assert sink.cycles[0] - bench.taken.cycles[0] == bench.cache.latency_of(policy)
        sink.stop()


@cocotb.test()
async def misses_overlap(dut):
    """As many records as there may be are fetched at a time, and come as fast as their beats, or as LFU finds lines."""
    await start(dut, cycles=50_000)
    bench = Bench(dut)
    beats, count = bench.size["beats"], 40
    fetches = bench.size["memsys.cache_fetches"]
    keys = np.arange(count) % (1 << bench.size["key"])
    for policy in CachePolicy:
        search = bench.size["memsys.lfu_count_bits"] + 5 if policy is CachePolicy.LFU else 0
        for delay in (1, 60):
            store = Store(bench, delay=lambda draw, delay=delay: delay, shuffles=False)
            sink, hit = await bench.run(keys, policy.name, store=store)
            assert not hit.any()
            # A slot is busy for the delay, the beats, and the way from memory through the cache and back.
            per_slot = (delay + beats + 8) / fetches
            limit = max(beats, search, per_slot)
            took = (sink.cycles[-1] - sink.cycles[8]) / (count - 9)
            assert took <= limit + 0.5, (policy, delay, took, limit)
            if search and delay == 1:
                assert set(np.diff(sink.cycles[8:])) == {search}
            store.stop()


@cocotb.test()
async def reset_in_flight(dut):
    """Nothing of before a reset comes out after it, and the cache is right again."""
    await start(dut, cycles=50_000)
    for wait in (1, 7, 20, 33):
        for policy in CachePolicy:
            bench = Bench(dut)
            store = Store(bench, delay=lambda draw: draw.randrange(1, 12), shuffles=True)
            await bench.invalidate(policy.name)
            sender = cocotb.start_soon(Source(dut, "i").send(bench.requests(bench.keys(60, wait))))
            sink = Sink(dut, "o", stalls=STALLS["alternating"](1))
            await ClockCycles(dut.clk, wait)
            sender.cancel()
            sink.stop()
            store.stop()
            bench.taken.stop()
            dut.i__valid.value = 0
            await reset(dut)
            bench = Bench(dut)
            bench.epoch = 100 + wait
            store = Store(bench, delay=lambda draw: 3, shuffles=False)
            await bench.run(bench.keys(40, wait), policy.name, store=store)
            store.stop()
            bench.taken.stop()


@cocotb.test()
async def invalidations_at_any_time(dut):
    """What was requested before is answered with what memory held before, what comes later with what it holds then."""
    await start(dut, cycles=100_000)
    bench = Bench(dut)
    draw = random.Random(bench.seed)
    Store(bench, delay=lambda draw: draw.randrange(1, 20), shuffles=True)
    sink = Sink(dut, "o", stalls=STALLS["random"](bench.seed))
    keys = bench.keys(300, 77)
    await bench.invalidate("LRU")
    policies, borders = ["LRU"], [0]
    sender = cocotb.start_soon(Source(dut, "i", stalls=STALLS["random"](bench.seed)).send(bench.requests(keys)))
    while len(bench.taken.items) < 250:
        await ClockCycles(dut.clk, draw.randrange(1, 120))
        policies.append(draw.choice(list(CachePolicy)).name)
        await bench.invalidate(policies[-1])
        borders.append(len(bench.taken.items))
    await sender
    expected = []
    for number, (first, last) in enumerate(zip(borders, [*borders[1:], len(keys)], strict=True)):
        expected += bench.expected(keys[first:last], bench.golden(policies[number]), first, number + 1)[0]
    assert len(borders) > 8
    await bench.finish(sink, expected)


@pytest.mark.parametrize("simulator", SIMULATORS)
@pytest.mark.parametrize("size", SIZES)
def test_in_the_simulator(size, simulator):
    simulate(make(SIZES[size]), __name__, simulator=simulator, size=SIZES[size])


@pytest.mark.parametrize("policy", CachePolicy, ids=lambda policy: policy.name)
def test_a_record_that_could_not_be_fetched_is_fetched_again(policy):
    """An error is answered to requests that were accepted before its first answer, and to none after it; the others get
    what a fetch of their record has brought.
    """
    beats, draw = 2, random.Random(f"{SEED} {policy.name}")
    dut = Cache(12, beats=beats, config=config_of({"memsys.lfu_count_bits": 2, "memsys.cache_fetches": 4}), lines=8,
                key=4, tag=1, policies=(policy,))
    failed, fetched = [], Counter()

    def fill(fetch):
        fetched[fetch["key"]] += 1
        number, bad = len(failed), draw.choice((-1, -1, 0, 1))
        failed.append(bad >= 0)
        return [{"slot": fetch["slot"], "beat": beat, "data": number, "error": beat == bad} for beat in range(beats)]

    bench = ScheduleBench(dut, idle_limit=60)
    keys = [draw.choice((draw.randrange(3), draw.randrange(16))) for _ in range(200)]
    schedule = Schedule(items={"i": [(draw.choice((0, 0, 0, 9)), {"key": key}) for key in keys]},
                        stalls={"o": [draw.choice((0, 0, 2)) for _ in keys]}, first={"i_invalidate": [policy.value]})
    came = bench.run(schedule, Responder("o_fetch", "i_fill", fill, after=(0, 12)))["o"]
    assert len(came) == len(keys)
    ended = {}
    for key, answer, accepted, cycle in zip(keys, came, bench.cycles["i"], bench.cycles["o"], strict=True):
        (number,) = {*answer["record"]}
        assert answer["error"] == failed[number]
        assert accepted < ended.get((key, number), cycle) or not answer["error"], "an error is answered too late"
        if answer["error"]:
            ended.setdefault((key, number), cycle)
    assert 10 < len(ended) < sum(answer["error"] for answer in came), "more than one request waits for an error"
    assert fetched.total() == sum(not answer["hit"] for answer in came)


@pytest.mark.parametrize(("changes", "message"), [
    ({"beats": 0}, "Beats must be at least 1, not 0"),
    ({"lines": 4}, "Lines must be a power of two, at least 8, not 4"),
    ({"policies": ()}, "Policies must be at least one CachePolicy, not ()"),
    ({"policies": ("lru",)}, "Policies must be a CachePolicy, not 'lru'")])
def test_init_wrong(changes, message):
    with pytest.raises(TypeError if "lru" in message else ValueError, match=f"^{re.escape(message)}$"):
        Cache(**{"beat": 8, "beats": 1, "config": config_of({}), "lines": 16, "key": 8, "tag": 1, **changes})


def test_each_policy_alone():
    config = config_of({})
    latency = {policy: Cache(8, beats=1, config=config, lines=16, key=8, tag=1, policies=(policy,)).latency
               for policy in CachePolicy}
    assert latency == {CachePolicy.DIRECT: documented_latency(Cache, config), CachePolicy.LRU: 9, CachePolicy.LFU: 7}


def test_policies_are_goldens():
    assert {policy.name: policy.value for policy in CachePolicy} == {
        policy.name: policy.value for policy in GoldenPolicy}
