# amaranth: UnusedElaboratable=no

from itertools import pairwise

import cocotb
import numpy as np
import pytest
from cocotb.triggers import ClockCycles, RisingEdge

from golden.config import PRESETS
from golden.stimulus import block
from golden.stimulus.ctu.ray_memory import SLOTS
from hw.ctu.ray_memory import RayMemory
from tb.lib.clocking import reset, start
from tb.lib.coverage import Coverage
from tb.lib.no_x import assert_known
from tb.lib.payload import pack, unpack
from tb.lib.runner import SIMULATORS, options, simulate
from tb.lib.stall_patterns import STALL_PAIRS, STALLS
from tb.lib.stream import Monitor, Sink, Source
from tb.lib.timing import documented_latency

MODULE = "tb.ctu.test_ray_memory"
STREAMS = ("i_start", "i", "i_return", "o")
VERSION_BITS, DEFERRED, GENERATION_BITS = 10, 8, 2
# Cycles from a return to the ray that leaves again.
AGAIN = 21
CASES = ("a ray leaves", "a request is dropped", "a request waits", "several wait for a slot",
         "a ray leaves again", "as many wait as can", "a request comes while the slot's chain is tried")


def make():
    return RayMemory(slots=SLOTS, version_bits=VERSION_BITS, deferred=DEFERRED, generation_bits=GENERATION_BITS, tag=16)


SHAPE = make().signature.members["i"].signature.members["payload"].shape


def request(slot, shell, tag=0, shape=SHAPE):
    """A request as an integer."""
    return pack(shape, {"slot": int(slot), "version": int(shell), "tag": int(tag)})


class Bench:
    """The streams of a ray memory; rays come back after random times, or after ``away`` cycles.

    Parameters
    ----------
    requests, sink
        Names of stall patterns.
    returns
        Rays come back.
    slots, shape, passed
        Of the memory: how many it has, the layout of a request, the streams of those that are dropped.
    """

    def __init__(self, dut, *, requests="none", sink="none", seed=0, returns=True, slots=SLOTS, shape=SHAPE,
                 passed=("o_passed",), away=None):
        self.dut, self.edge, self._random = dut, RisingEdge(dut.clk), np.random.default_rng([seed, options()["seed"]])
        self.start, self.back = Source(dut, "i_start"), Source(dut, "i_return")
        self.request = Source(dut, "i", stalls=STALLS[requests](options()["seed"]))
        self.taken, self._passed = Monitor(dut, "i"), [Monitor(dut, name) for name in passed]
        self._slots, self._shape, self._time = slots, shape, away
        self.away, self.left, self.cycles = {}, [], []
        self.sink = Sink(dut, "o", stalls=STALLS[sink](options()["seed"] + 1))
        self._tasks = [cocotb.start_soon(task()) for task in (self._follow, self._return)] if returns else []

    def stop(self):
        for task in self._tasks:
            task.cancel()
        for monitor in (self.taken, *self._passed, self.sink):
            monitor.stop()
        for source in (self.start, self.back, self.request):
            source.valid.value = 0

    async def _follow(self):
        seen = 0
        while True:
            await self.edge
            for item in self.sink.items[seen:]:
                ray = unpack(self._shape, item)
                assert ray["slot"] not in self.away, "two copies of a ray must never be in flight"
                self.away[ray["slot"]] = self._time or int(self._random.integers(1, 30))
                self.left.append((ray["slot"], ray["version"], ray["tag"]))
            seen = len(self.sink.items)

    async def _return(self):
        """One ray per cycle at most."""
        while True:
            back = [slot for slot, time in self.away.items() if time <= 0]
            self.away = {slot: time - 1 for slot, time in self.away.items()}
            self.dut.i_return__valid.value = bool(back)
            if back:
                slot = int(self._random.choice(back))
                del self.away[slot]
                self.dut.i_return__payload.value = slot
            await self.edge

    async def settled(self):
        """Until no ray is away and nothing waits."""
        quiet = 0
        while quiet < 2 * AGAIN:
            await self.edge
            busy = self.away or int(self.dut.waiting.value) or int(self.dut.o__valid.value)
            quiet = 0 if busy else quiet + 1

    async def frustum(self, shells=4):
        """Requests of rising shells, several for each slot and shell: each slot leaves once for each shell."""
        await self.start.send([0])
        before, passed = len(self.left), [len(monitor.items) for monitor in self._passed]
        some = self._random.choice(np.arange(1, 1 << VERSION_BITS), shells, replace=False)
        asked = [(int(slot), shell) for shell in sorted(some.tolist())
                 for slot in self._random.integers(self._slots, size=2 * self._slots)]
        await self.request.send(request(*one, tag, self._shape) for tag, one in enumerate(asked))
        await self.settled()
        left = self.left[before:]
        assert len({ray[:2] for ray in left}) == len(left), "a ray must leave once per shell"
        assert {ray[:2] for ray in left} == set(asked), "no request may be lost"
        assert all(asked[tag] == (slot, shell) for slot, shell, tag in left)
        for slot in {ray[0] for ray in left}:
            served = [tag for other, _, tag in left if other == slot]
            assert served == sorted(served), "requests for a slot must be served in their order"
        tags = sorted([tag for *_, tag in left] + [
            tag for monitor, seen in zip(self._passed, passed, strict=True) for tag in monitor.items[seen:]])
        assert tags == list(range(len(asked))), "each request must leave or be dropped, once"


class Watch:
    """Counts the cases of the traffic, from the requests and what they must come to.

    Parameters
    ----------
    deferred
        Requests that can wait.
    """

    def __init__(self, dut, *, deferred=DEFERRED):
        self.coverage, self._dut, self._deferred = Coverage(CASES), dut, deferred
        cocotb.start_soon(self._run())

    async def _run(self):
        dut, edge, asked, waited, back = self._dut, RisingEdge(self._dut.clk), {}, 0, {}
        cycle = 0
        while True:
            await edge
            cycle += 1
            if int(dut.i_start__valid.value) and int(dut.i_start__ready.value):
                asked = {}
            if int(dut.i_return__valid.value):
                back[int(dut.i_return__payload.value)] = cycle
            waiting = int(dut.waiting.value)
            self.coverage.hit_all({"a request waits": waiting > waited,
                                   "as many wait as can": waiting == self._deferred})
            waited = waiting
            if int(dut.i__valid.value) and int(dut.i__ready.value):
                ray = unpack(SHAPE, int(dut.i__payload.value))
                slot, shell = ray["slot"], ray["version"]
                seen = asked.setdefault(slot, [])
                self.coverage.hit("a request is dropped", shell in seen)
                self.coverage.hit("several wait for a slot", len(set(seen)) > 2 and waiting > 2)
                self.coverage.hit("a request comes while the slot's chain is tried",
                                  waiting and cycle - back.get(slot, -99) in range(2, AGAIN))
                seen.append(shell)
            if int(dut.o__valid.value) and int(dut.o__ready.value):
                ray = unpack(SHAPE, int(dut.o__payload.value))
                self.coverage.hit("a ray leaves again" if ray["slot"] in back else "a ray leaves")


@cocotb.test()
async def every_pair_of_stalls(dut):
    """Each slot leaves once for each shell that was asked for, one copy at a time."""
    await start(dut, cycles=100_000)
    watch = None
    for number, (requests, sink) in enumerate(STALL_PAIRS):
        bench = Bench(dut, requests=requests, sink=sink, seed=number)
        dut.i_return__valid.value = 0
        await RisingEdge(dut.clk)
        assert_known(dut, STREAMS)
        watch = watch or Watch(dut)
        await bench.frustum()
        bench.stop()
    watch.coverage.check()


@cocotb.test()
async def one_after_the_other(dut):
    """Golden's stimulus, each access when the one before it is over."""
    await start(dut, cycles=20_000)
    bench = Bench(dut, returns=False)
    of = block("ctu.ray_memory")[1]
    given = of.draw(np.random.default_rng(options()["seed"]), 200, PRESETS["tiny"])
    wanted = of.expect(given, PRESETS["tiny"])
    await bench.start.send([0])
    for number, completes in enumerate(given["completes"].tolist()):
        slot, came = int(given["slot"][number]), len(bench.sink.items)
        if completes:
            await bench.back.send([slot])
        elif wanted["looked_at"][number]:
            await bench.request.send([request(slot, given["shell"][number], given["subshell"][number])])
        else:
            continue
        await ClockCycles(dut.clk, 2 * AGAIN + 2)
        left = [unpack(SHAPE, item) for item in bench.sink.items[came:]]
        expected = [{"slot": slot, "version": int(wanted["leaves_shell"][number]),
                     "tag": int(wanted["leaves_subshell"][number])}] if wanted["leaves"][number] else []
        assert left == expected, number
        assert int(dut.waiting.value) == wanted["waiting"][number]


@cocotb.test()
async def reset_in_flight(dut):
    """Nothing of before a reset comes out, whatever was in flight."""
    await start(dut, cycles=20_000)
    for number, cut in enumerate((1, 3, 6, 9, 14, 33)):
        bench = Bench(dut, seed=number)
        await bench.start.send([0])
        sending = cocotb.start_soon(bench.request.send(request(k % 3, 1 + k // 3) for k in range(40)))
        await ClockCycles(dut.clk, cut)
        sending.cancel()
        bench.stop()
        await reset(dut)
        bench = Bench(dut, seed=number)
        await ClockCycles(dut.clk, 2 * AGAIN)
        assert not bench.sink.items
        assert not int(dut.waiting.value)
        await bench.frustum(shells=3)
        bench.stop()


@cocotb.test()
async def one_access_per_cycle(dut):
    """Requests are taken and rays leave one per cycle, after the latencies that the docstring states."""
    await start(dut, cycles=2_000)
    bench = Bench(dut, returns=False)
    await bench.start.send([0])
    await bench.request.send([request(k, 5, k) for k in range(SLOTS)])
    await ClockCycles(dut.clk, 14)
    assert {b - a for a, b in pairwise(bench.taken.cycles)} == {1}, "requests must be taken without a gap"
    assert {b - a for a, b in pairwise(bench.sink.cycles)} == {1}, "rays must leave without a gap"
    assert bench.sink.cycles[0] - bench.taken.cycles[0] == documented_latency(RayMemory, PRESETS["tiny"])
    # The same again are dropped at that rate; later ones wait.
    taken, left = len(bench.taken.cycles), len(bench.sink.cycles)
    await bench.request.send([request(k, 5) for k in range(SLOTS)])
    await bench.request.send([request(k, 6, k) for k in range(min(SLOTS, DEFERRED))])
    await ClockCycles(dut.clk, 14)
    assert len(bench.sink.cycles) == left
    assert int(dut.waiting.value) == min(SLOTS, DEFERRED)
    assert {b - a for a, b in pairwise(bench.taken.cycles[taken:taken + SLOTS])} == {1}
    # Rays come back, one per cycle, and leave again so.
    back = Monitor(dut, "i_return")
    await bench.back.send(range(min(SLOTS, DEFERRED)))
    await ClockCycles(dut.clk, 2 * AGAIN)
    again = bench.sink.cycles[left:]
    assert len(again) == min(SLOTS, DEFERRED)
    assert {b - a for a, b in pairwise(back.cycles)} == {1}, "returns never stall"
    assert {b - a for a, b in pairwise(again)} == {1}, "those that waited must leave without a gap"


@cocotb.test()
async def a_return_to_one_request(dut):
    """The ray leaves again after the latency that the docstring states; a full store stalls requests only."""
    await start(dut, cycles=2_000)
    bench = Bench(dut, returns=False)
    await bench.start.send([0])
    await bench.request.send([request(2, 1), *(request(2, 2 + k, k) for k in range(DEFERRED))])
    await ClockCycles(dut.clk, 14)
    assert int(dut.waiting.value) == DEFERRED
    stuck = cocotb.start_soon(bench.request.send([request(3, 1, 77)]))
    await ClockCycles(dut.clk, 14)
    assert not stuck.done()
    back = Monitor(dut, "i_return")
    for k in range(DEFERRED):
        left = len(bench.sink.items)
        await bench.back.send([2])
        await ClockCycles(dut.clk, 2 * AGAIN)
        rays = [unpack(SHAPE, item) for item in bench.sink.items[left:]]
        assert [ray for ray in rays if ray["slot"] == 2] == [{"slot": 2, "version": 2 + k, "tag": k}]
        assert bench.sink.cycles[left] - back.cycles[-1] == AGAIN
    assert stuck.done()


@cocotb.test()
async def returns_block_retries(dut):
    """First come, first served: also if the ray is back while returns block those behind the one that it left for."""
    await start(dut, cycles=100_000)
    others = SLOTS - 1
    for begin in range(AGAIN + 2):
        for until in range(begin + 2, AGAIN + 14, 4):
            bench = Bench(dut, returns=False)
            await bench.start.send([0])
            await bench.request.send([request(0, 1), *(request(1 + k, 1) for k in range(others)),
                                      *(request(0, 2 + k, k) for k in range(DEFERRED))])
            await ClockCycles(dut.clk, AGAIN)
            assert int(dut.waiting.value) == DEFERRED
            seen, left = len(bench.sink.items), []
            idle, cycle = 0, -1
            while idle < 2 * AGAIN:
                # The hot slot's ray comes back at once; a return of another slot's ray does not change its slot.
                came = [unpack(SHAPE, item) for item in bench.sink.items[seen:]]
                seen += len(came)
                left += [ray["tag"] for ray in came]
                back = cycle < 0 or bool(came)
                dut.i_return__valid.value = back or begin <= cycle < until
                dut.i_return__payload.value = 0 if back else 1 + cycle % others
                cycle, idle = cycle + 1, 0 if back or cycle < until else idle + 1
                await bench.edge
            assert left == list(range(DEFERRED)), (begin, until)
            bench.stop()


ALL = ("every_pair_of_stalls", "one_after_the_other", "reset_in_flight", "one_access_per_cycle",
       "a_return_to_one_request", "returns_block_retries")


@pytest.mark.parametrize("simulator", [SIMULATORS[0], pytest.param("icarus", marks=pytest.mark.nightly)])
def test_in_the_simulator(simulator):
    simulate(make(), MODULE, ALL, simulator=simulator, name=f"ctu_ray_memory-{simulator}")


@pytest.mark.parametrize(("name", "message"), [
    ("slots", "Slots"), ("version_bits", "Version bits"), ("deferred", "Deferred"),
    ("generation_bits", "Generation bits")])
@pytest.mark.parametrize(("value", "error"), [(0, ValueError), (1.0, TypeError)])
def test_init_wrong_size(name, message, value, error):
    sizes = {"slots": 4, "version_bits": 4, "deferred": 2, "generation_bits": 1, name: value}
    with pytest.raises(error, match=f"^{message} must be at least 1, not {value!r}$"):
        RayMemory(tag=4, **sizes)
