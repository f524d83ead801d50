"""Each request gets its patch once; one fetch serves all who wait for it; a lost fetch holds nobody up."""

import random
from collections import Counter, deque
from itertools import pairwise

import pytest
from amaranth.hdl import ResetInserter, Signal

from golden.engine.memsys.patches.patch_store import KEPT_OF
from golden.engine.memsys.patches.patch_store import PatchStore as GoldenStore
from hw.formats import VERTICES
from hw.memsys.patches.patch_store import PatchStore
from tb.lib.configurations import config_of
from tb.lib.simulator import simulator_of
from tb.lib.timing import documented_latency

CONFIG = config_of({"icu.patch_bits": 8})
FRAMES, REQUESTS = 8, 4
# Cycles without an event after which a run has failed.
LIMIT = 200


def surface_of(patch):
    return (patch * 5 - 40) % 100 - 20


def node_of(patch):
    """The cluster that a request names, of those that a configuration has."""
    return patch // 2 % CONFIG.noc.nodes


def vertices_of(patch):
    return [[patch * 16 + k * 4 + axis for axis in range(3)] for k in range(VERTICES)]


class Run:
    """A store with requests, and a memory that answers its fetches.

    Parameters
    ----------
    patches
        Requests in their order.
    spread, least
        Fetches are answered after 1 to so many cycles, and ``least`` more, in any order.
    gap
        Cycles between requests at most; None: each comes when the one before has been answered.
    stall
        Share of the cycles in which outputs are not ready.
    lost
        Numbers of the fetches that fail.
    restarts
        Numbers of requests before which the store is emptied.
    void
        Patches whose vertices are all 0.
    resets
        Cycles in which the store is reset with all that is in flight, which is requested again.
    """

    def __init__(self, patches, *, seed=1, spread=30, least=0, gap=0, stall=0.0, lost=(), void=(), restarts=(),
                 resets=()):
        self.patches, self.draw, self.spread, self.gap = list(patches), random.Random(seed), spread, gap
        self.void = set(void)
        self.least, self.stall, self.lost_fetches = least, stall, set(lost)
        self.restarts, self.resets = set(restarts), set(resets)
        self.fetched, self.answers, self.lost, self.accepted, self.times = [], [], 0, [], []
        self.at_fetch, self.first_vertex, self.hits = [], [], None
        # Requests accepted and answered before each reset.
        self.before_resets = [(0, 0)]
        dut = PatchStore(config=CONFIG, frames=FRAMES, requests=REQUESTS)
        self.reset = Signal()
        simulator = simulator_of(ResetInserter(self.reset)(dut))
        self.cycle = self.event = 0

        async def bench(ctx):
            await self._drive(ctx, dut)

        simulator.add_testbench(bench)
        simulator.run()

    def vertices_of(self, patch):
        return [[0, 0, 0]] * VERTICES if patch in self.void else vertices_of(patch)

    async def _drive(self, ctx, dut):
        waiting, sending, failed = [], deque(), deque()
        parts = {"o_stored": [], "o_passed": []}
        number, wait, restarts, fetches = 0, 0, True, 0
        ended = 0
        while ended < len(self.patches):
            self.cycle += 1
            assert self.cycle - self.event < LIMIT, f"nothing occurs after {ended} of {len(self.patches)} requests"
            ctx.set(dut.i_start.valid, int(restarts))
            offers = not restarts and number < len(self.patches) and wait <= 0 and (
                self.gap is not None or ended == number)
            ctx.set(dut.i.valid, int(offers))
            if number < len(self.patches):
                patch = self.patches[number]
                ctx.set(dut.i.payload, {"patch": patch, "node": node_of(patch), "is_remote": patch & 1})
            ctx.set(dut.o_fetch.ready, int(self.draw.random() >= self.stall))
            due = [item for item in waiting if item[0] <= self.cycle]
            # A failure is known at any time, also between two vertices of another patch.
            for item in [item for item in due if item[2] in self.lost_fetches]:
                waiting.remove(item)
                due.remove(item)
                failed.append(item[1])
            if due and not sending and self.draw.random() < 0.8:
                item = self.draw.choice(due)
                waiting.remove(item)
                sending.extend({"patch": item[1], "surface": surface_of(item[1]), "vertex": vertex}
                               for vertex in self.vertices_of(item[1]))
            ctx.set(dut.i_fill.valid, int(bool(sending)))
            if sending:
                ctx.set(dut.i_fill.payload, sending[0])
            ctx.set(dut.i_lost.valid, int(bool(failed)))
            if failed:
                ctx.set(dut.i_lost.payload, failed[0])
            for name in parts:
                ctx.set(getattr(dut, name).ready, int(self.draw.random() >= self.stall))
            accepted = offers and ctx.get(dut.i.ready)
            started = restarts and ctx.get(dut.i_start.ready)
            if ctx.get(dut.o_fetch.valid) and ctx.get(dut.o_fetch.ready):
                fetch = dut.o_fetch.payload
                patch = ctx.get(fetch.patch)
                where = ctx.get(fetch.is_remote), ctx.get(fetch.node)
                assert where == (patch & 1, node_of(patch)), "a fetch says where its patch is"
                waiting.append((self.cycle + 1 + self.least + self.draw.randrange(self.spread), patch, fetches))
                self.fetched.append(patch)
                self.at_fetch.append(self.cycle)
                fetches, self.event = fetches + 1, self.cycle
            for name, part in parts.items():
                stream = getattr(dut, name)
                if ctx.get(stream.valid) and ctx.get(stream.ready):
                    if not part:
                        self.first_vertex.append(self.cycle)
                    vertex = stream.payload
                    part.append((ctx.get(vertex.patch), ctx.get(vertex.surface),
                                 [ctx.get(vertex.vertex[axis]) for axis in range(3)]))
                    if len(part) == VERTICES:
                        ((patch, surface),) = {one[:2] for one in part}
                        assert surface == surface_of(patch)
                        assert [one[2] for one in part] == self.vertices_of(patch), "vertices stay together"
                        self.answers.append(patch)
                        part.clear()
                        ended, self.event = ended + 1, self.cycle
            lost = ctx.get(dut.lost).bit_count()
            if lost:
                self.lost, ended, self.event = self.lost + lost, ended + lost, self.cycle
            filled = sending and ctx.get(dut.i_fill.ready)
            dropped = failed and ctx.get(dut.i_lost.ready)
            ctx.set(self.reset, int(self.cycle in self.resets))
            await ctx.tick()
            if self.cycle in self.resets:
                for queue in (waiting, sending, failed, *parts.values()):
                    queue.clear()
                number, restarts = ended, True
                self.before_resets.append((len(self.accepted), len(self.answers)))
                continue
            wait -= 1
            if filled:
                sending.popleft()
            if dropped:
                failed.popleft()
            if started:
                restarts, self.event = False, self.cycle
            if accepted:
                self.accepted.append(self.patches[number])
                self.times.append(self.cycle)
                number, self.event = number + 1, self.cycle
                wait = self.draw.randrange(self.gap + 1) if self.gap else 0
                restarts = number in self.restarts
        for _ in range(20):
            ctx.set(dut.i.valid, 0)
            late = [name for name in parts if ctx.get(getattr(dut, name).valid)]
            assert (late, ctx.get(dut.lost)) == ([], 0), "each request is answered once"
            await ctx.tick()
        self.hits, self.deferred = ctx.get(dut.hits), ctx.get(dut.deferred)


def assert_answered(run, patches):
    """Each request once: in the order of the memory's answers, which is any."""
    assert Counter(run.answers) == Counter(patches), "each request is answered once"


# A commit's tests have one of them.
SEEDS = [0, *(pytest.param(seed, marks=pytest.mark.sim) for seed in (1, 2))]


def drawn(count, seed, *, most):
    draw = random.Random(seed)
    return [draw.randrange(most) for _ in range(count)]


@pytest.mark.parametrize(("gap", "stall", "most"), [
    (0, 0.6, 6), *(pytest.param(*one, marks=pytest.mark.sim) for one in (
        (0, 0.0, 20), (12, 0.3, 200), (0, 0.0, 6), (0, 0.0, 200), (0, 0.6, 200), (12, 0.3, 6)))])
def test_each_request_gets_its_patch_once(gap, stall, most):
    patches = drawn(60, most, most=most)
    run = Run(patches, seed=most, gap=gap, stall=stall)
    assert_answered(run, patches)
    assert run.hits == len(patches) - len(run.fetched)
    assert len(run.fetched) >= len({*patches}), "a patch that is not there is fetched"


def fetches(patches, restarts=()):
    """What golden fetches of a string of requests."""
    store, fetched = GoldenStore(FRAMES), []
    for number, patch in enumerate(patches):
        if number in restarts:
            store.clear()
        fetched += [] if store.request(patch) else [patch]
    assert (store.hits, store.misses) == (len(patches) - len(fetched), len(fetched))
    return fetched


@pytest.mark.parametrize(("gap", "stall", "spread"), [
    (12, 0.3, 5), pytest.param(0, 0.0, 30, marks=pytest.mark.sim),
    pytest.param(None, 0.0, 30, marks=pytest.mark.sim), pytest.param(0, 0.6, 90, marks=pytest.mark.sim)])
def test_fetches_follow_from_the_order_of_requests(gap, stall, spread):
    """Whatever overlaps: the fetches are golden's, in its order; also of a store that was emptied."""
    patches, restarts = drawn(240, 7, most=24), (80, 81, 160)
    run = Run(patches, gap=gap, stall=stall, spread=spread, restarts=restarts)
    assert run.fetched == fetches(patches, restarts)
    assert_answered(run, patches)
    assert {patch for patch in patches if fetches(patches).count(patch) > 2}, "patches are replaced"


def test_one_fetch_serves_all_who_wait():
    patches = [3, 3, 3, 5, 3, 5, 5, 3]
    run = Run(patches, spread=1, gap=0)
    assert run.fetched == [3, 5]
    assert_answered(run, patches)


def test_what_waits_for_a_fetch_is_counted():
    """All in flight where the fetch takes longest; where requests come one by one, those alone that are fetched and
    kept.
    """
    assert Run([3] * REQUESTS, least=60).deferred == REQUESTS
    patches = [3, 3, 5, 5 + FRAMES, 3, 5 + FRAMES, 5]
    run = Run(patches, gap=None)
    assert run.fetched == [3, 5, 5 + FRAMES, 5 + FRAMES]
    assert run.deferred == len({3, 5}), "what is passed on waits in no frame"


def test_a_frame_in_use_is_not_renewed():
    """Patches of one frame, all in flight at once: the first one is kept; the one that replaces it waits for it."""
    patches = [1, 1 + FRAMES, 1 + 2 * FRAMES, 1, 1 + FRAMES]
    run = Run(patches, spread=60, gap=0)
    assert_answered(run, patches)
    assert run.fetched == [1, 1 + FRAMES, 1 + 2 * FRAMES, 1 + FRAMES]
    others = [2 + FRAMES * (k % 3 + 1) for k in range(KEPT_OF - 1)]
    run = Run([2, *others, 2, 1, 2 + 4 * FRAMES, 2 + 4 * FRAMES, 2], spread=60, gap=0)
    assert run.fetched == [2, *others, 1, 2 + 4 * FRAMES, 2]
    # The last requests of what is replaced are in flight still.
    run = Run([2, *others, 2, 2, 2 + 4 * FRAMES, 2 + 4 * FRAMES, 2], spread=60, gap=0)
    assert run.fetched == [2, *others, 2 + 4 * FRAMES, 2]


def test_a_scene_larger_than_the_store_keeps_its_share():
    """The same patches again and again: a store that replaced one at each miss would never hit."""
    frustum = [*range(3 * FRAMES)]
    run = Run(frustum * 8, gap=0, spread=3)
    assert run.fetched == fetches(frustum * 8)
    assert run.hits > 0.2 * 8 * len(frustum)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_lost_fetch_ends_all_who_wait_and_is_fetched_again(seed):
    patches = [2, 2, 2 + FRAMES, 2, *drawn(30, seed, most=14)]
    lost = {0, 1, *random.Random(seed).sample(range(2, 12), 4)}
    run = Run(patches, seed=seed, lost=lost, stall=0.2)
    assert Counter(run.answers) <= Counter(patches), "in the order of the memory's answers; what misses is lost"
    assert len(run.answers) < len(patches)
    missing = Counter(patches) - Counter(run.answers)
    assert run.lost == missing.total(), "each request is answered or lost"
    later = Run([4, 4], lost={0}, gap=None)
    assert (later.answers, later.lost, later.fetched) == ([4], 1, [4, 4])


@pytest.mark.parametrize("stall", [pytest.param(0.0, marks=pytest.mark.sim), 0.5])
def test_a_patch_that_is_nowhere_is_answered_and_never_kept(stall):
    patches = [3, 3, 5, 3 + FRAMES, 3, *drawn(30, 9, most=12)]
    run = Run(patches, void={3}, gap=None, stall=stall)
    assert run.answers == patches
    assert run.fetched.count(3) == patches.count(3)
    assert run.fetched.count(5) == 1
    run = Run(patches * 3, void={3, 4}, gap=0, stall=stall)
    assert_answered(run, patches * 3)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_reset_forgets_all_that_is_in_flight(seed):
    patches = drawn(40, seed, most=14)
    run = Run(patches, seed=seed, resets=random.Random(seed).sample(range(20, 250), 3), stall=0.2)
    assert len(run.answers) == len(patches)
    for (first, answered), (end, ends) in pairwise([*run.before_resets, (len(run.accepted), len(run.answers))]):
        came, given = Counter(run.answers[answered:ends]), Counter(run.accepted[first:end])
        # A reset ends requests; what has been answered before is of the requests since the reset before.
        assert came <= given
    assert came == given, "behind the last reset each request is answered once"


def test_rate_and_latency():
    """A patch every four cycles of what is kept; the first vertex after the documented latency."""
    warm = [*range(FRAMES)]
    run = Run([*warm, *warm * 6], gap=0, spread=2)
    # What has been fetched before is answered without a gap: four vertices each.
    later = run.first_vertex[3 * FRAMES:]
    assert {b - a for a, b in pairwise(later)} == {VERTICES}
    alone = Run([5, 5], gap=None, spread=2)
    assert alone.first_vertex[1] - alone.times[1] == documented_latency(PatchStore, CONFIG)
    assert alone.at_fetch[0] - alone.times[0] == 3
