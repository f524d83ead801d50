"""The environment of a ray memory of cell traversal, and coroutines for one memory and for several banks."""

import importlib
from collections import deque
from itertools import pairwise
from random import Random

import cocotb
import numpy as np
from amaranth.hdl import Value
from cocotb.triggers import ClockCycles, RisingEdge

from golden.engine.config import PRESETS
from golden.engine.stimulus import block
from hw.lib.payload import unpack
from tb.lib.clocking import start
from tb.lib.coverage import Coverage
from tb.lib.no_x import assert_known
from tb.lib.ports import Ports
from tb.lib.runner import options
from tb.lib.signature import payload_shape
from tb.lib.simulator import simulator_of
from tb.lib.stall_patterns import STALL_PAIRS

__all__ = ["Rays", "check_rate", "play", "request"]

CASES = ("a ray leaves", "a request is dropped", "a request waits", "several wait for a slot",
         "a ray leaves again", "as many wait as can", "a request comes while the slot's chain is tried")


def request(slot, shell, tag=0):
    """A request."""
    return {"slot": int(slot), "version": int(shell), "tag": int(tag)}


class Rays:
    """The streams of a ray memory; rays come back after random times, or after ``away`` cycles.

    The options name the module that makes the memory, with ``make``, ``DEFERRED`` and ``AGAIN``, and its ``slots``.

    Parameters
    ----------
    stalls
        By stream.
    returns
        Rays come back.
    """

    def __init__(self, dut, *, seed=0, returns=True, away=None, **stalls):
        given = options()
        self.module, self._slots = importlib.import_module(given["memory"]), given["slots"]
        self.again = self.module.AGAIN
        self.ports = ports = Ports(dut, self.module.make(self._slots), stalls=stalls)
        self.dut, self.edge, self._random = dut, ports.edge, np.random.default_rng([seed, given["seed"]])
        self._time, self.away, self.left = away, {}, []
        self.sink, self.taken = ports.sinks["o"], ports.taken("i")
        self._passed = [sink for name, sink in ports.sinks.items() if name.startswith("o_passed")]
        if returns:
            ports.run(self._follow())
            ports.run(self._return())

    async def _follow(self):
        seen = 0
        while True:
            await self.edge
            for ray in self.ports.came("o", seen):
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
        """Wait until no ray is away and no request is deferred."""
        quiet = 0
        while quiet < 2 * self.again:
            await self.edge
            busy = self.away or int(self.dut.waiting.value) or int(self.dut.o__valid.value)
            quiet = 0 if busy else quiet + 1

    async def frustum(self, shells=4):
        """Requests of rising shells, several for each slot and shell: each slot leaves once for each shell."""
        await self.ports.send("i_start", [0])
        before, passed = len(self.left), [len(monitor.items) for monitor in self._passed]
        some = self._random.choice(np.arange(1, 1 << self.module.VERSION_BITS), shells, replace=False)
        requested = [(int(slot), shell) for shell in sorted(some.tolist())
                 for slot in self._random.integers(self._slots, size=2 * self._slots)]
        await self.ports.send("i", [request(*one, tag) for tag, one in enumerate(requested)])
        await self.settled()
        check_frustum(requested, self.left[before:], [
            tag for monitor, seen in zip(self._passed, passed, strict=True) for tag in monitor.items[seen:]])


def check_frustum(requested, left, passed):
    """Requests of slots and shells, whose tags are their numbers; slots, shells and tags of rays; tags that passed."""
    assert len({ray[:2] for ray in left}) == len(left), "a ray must leave once per shell"
    assert {ray[:2] for ray in left} == set(requested), "no request may be lost"
    assert all(requested[tag] == (slot, shell) for slot, shell, tag in left)
    for slot in {ray[0] for ray in left}:
        served = [tag for other, _, tag in left if other == slot]
        assert served == sorted(served), "requests for a slot must be served in their order"
    tags = sorted([*(tag for *_, tag in left), *passed])
    assert tags == list(range(len(requested))), "each request must leave or be dropped, once"


def play(dut, passed, *, slots, frusta, seed):
    """Frusta in Amaranth's simulator, most of whose requests are for a few slots.

    Parameters
    ----------
    dut, passed
        The memory, and its streams of requests that are dropped.
    slots, frusta, seed
        Its slots; how many frusta; of all that is drawn.
    """
    random, made = Random(seed), dut.o.payload.shape()
    outputs = [Value.cast(one) for one in (
        dut.i_start.ready, dut.i.ready, dut.o.valid, dut.o.payload,
        *(part for one in passed for part in (one.valid, one.payload)))]

    async def frustum(ctx):
        # Slots may be idle for as many frusta as there are tags of generations.
        used = random.sample(range(slots), random.choice((2, slots)))
        requested = [(random.choice((*used[:2], used[0], random.choice(used))), shell)
                     for shell in sorted(random.sample(range(1, 16), 9)) for _ in range(random.randint(1, slots))]
        waiting, away, left, dropped, begun, returns = deque(enumerate(requested)), [], [], [], False, 0
        for _ in range(60 * len(requested)):
            if len(left) + len(dropped) == len(requested) and not away:
                break
            offers, takes = begun and bool(waiting), random.random() < 0.8
            ctx.set(dut.i_start.valid, int(not begun))
            ctx.set(dut.i.valid, int(offers))
            if offers:
                ctx.set(dut.i.payload, request(*waiting[0][1], waiting[0][0]))
            ctx.set(dut.o.ready, int(takes))
            # Rays come back one behind the other now and then.
            returns = returns - 1 if returns else random.choice((1, 9, 20)) if random.random() < 0.04 else 0
            back = random.choice(away) if away and returns else None
            ctx.set(dut.i_return.valid, int(back is not None))
            if back is not None:
                away.remove(back)
                ctx.set(dut.i_return.payload, back)
            _, _, starts, accepts, comes, ray, *drops = await ctx.tick().sample(*outputs)
            begun |= bool(starts)
            if offers and accepts:
                waiting.popleft()
            if takes and comes:
                ray = unpack(made, ray)
                assert ray["slot"] not in away, "two copies of a ray must never be in flight"
                away.append(ray["slot"])
                left.append((ray["slot"], ray["version"], ray["tag"]))
            dropped += [tag for valid, tag in zip(drops[::2], drops[1::2], strict=True) if valid]
        check_frustum(requested, left, dropped)

    async def bench(ctx):
        for _ in range(frusta):
            await frustum(ctx)

    simulator_of(dut, bench).run()


class Watch:
    """Counts the cases of functional coverage that requests and their expected outcomes meet."""

    def __init__(self, rays):
        self.coverage, self._dut, self._module = Coverage(CASES), rays.dut, rays.module
        self._shape = payload_shape(rays.module.make(options()["slots"]).signature, "i")
        cocotb.start_soon(self._run())

    async def _run(self):
        dut, edge, versions, waited, back = self._dut, RisingEdge(self._dut.clk), {}, 0, {}
        cycle = 0
        while True:
            await edge
            cycle += 1
            if int(dut.i_start__valid.value) and int(dut.i_start__ready.value):
                versions = {}
            if int(dut.i_return__valid.value):
                back[int(dut.i_return__payload.value)] = cycle
            waiting = int(dut.waiting.value)
            self.coverage.hit_all({"a request waits": waiting > waited,
                                   "as many wait as can": waiting == self._module.DEFERRED})
            waited = waiting
            if int(dut.i__valid.value) and int(dut.i__ready.value):
                ray = unpack(self._shape, int(dut.i__payload.value))
                slot, shell = ray["slot"], ray["version"]
                seen = versions.setdefault(slot, [])
                self.coverage.hit("a request is dropped", shell in seen)
                self.coverage.hit("several wait for a slot", len(set(seen)) > 2 and waiting > 2)
                self.coverage.hit("a request comes while the slot's chain is tried",
                                  waiting and cycle - back.get(slot, -99) in range(2, self._module.AGAIN))
                seen.append(shell)
            if int(dut.o__valid.value) and int(dut.o__ready.value):
                ray = unpack(self._shape, int(dut.o__payload.value))
                self.coverage.hit("a ray leaves again" if ray["slot"] in back else "a ray leaves")


def check_rate(cycles, what):
    """One in each cycle."""
    assert {b - a for a, b in pairwise(cycles)} == {1}, f"{what} without a gap"


@cocotb.test()
async def every_pair_of_stalls(dut):
    """Each slot leaves once for each shell that was requested, one copy at a time."""
    await start(dut, cycles=100_000)
    watch = None
    for number, (requests, sink) in enumerate(STALL_PAIRS):
        rays = Rays(dut, i=requests, o=sink, seed=number)
        await rays.edge
        assert_known(dut, [*rays.ports.sources, *rays.ports.sinks])
        watch = watch or Watch(rays)
        await rays.frustum()
        rays.ports.stop()
    watch.coverage.check()


@cocotb.test()
async def one_after_the_other(dut):
    """Golden's stimulus, each access when the one before it is over."""
    await start(dut, cycles=20_000)
    rays, of = Rays(dut, returns=False), block("ctu.ray_memory")[1]
    ports, given = rays.ports, of.draw(np.random.default_rng(options()["seed"]), 200, PRESETS["tiny"])
    predicted = of.expect(given, PRESETS["tiny"])
    await ports.send("i_start", [0])
    for number, completes in enumerate(given["completes"].tolist()):
        slot, came = int(given["slot"][number]), len(rays.sink.items)
        if completes:
            await ports.send("i_return", [slot])
        elif predicted["looked_at"][number]:
            await ports.send("i", [request(slot, given["shell"][number], given["subshell"][number])])
        else:
            continue
        await ClockCycles(dut.clk, 2 * rays.again + 2)
        expected = [request(slot, predicted["leaves_shell"][number], predicted["leaves_subshell"][number])]
        assert ports.came("o", came) == expected * bool(predicted["leaves"][number]), number
        assert ports["waiting"] == predicted["waiting"][number]


@cocotb.test()
async def reset_in_flight(dut):
    """Nothing of before a reset comes out, whatever was in flight."""
    await start(dut, cycles=20_000)
    for number, cut in enumerate((1, 3, 6, 9, 14, 33)):
        rays = Rays(dut, seed=number)
        await rays.ports.send("i_start", [0])
        rays.ports.begin("i", [request(k % 3, 1 + k // 3) for k in range(40)])
        await ClockCycles(dut.clk, cut)
        await rays.ports.reset()
        rays.ports.stop()
        rays = Rays(dut, seed=number)
        await ClockCycles(dut.clk, 2 * rays.again)
        assert not rays.sink.items
        assert not rays.ports["waiting"]
        await rays.frustum(shells=3)
        rays.ports.stop()
