from itertools import cycle, islice, pairwise

from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In
from hypothesis import given
from hypothesis import strategies as st

from hw.icu.patch_queue import PatchQueue
from tb.lib.configurations import config_of
from tb.lib.coverage import Coverage
from tb.lib.schedules import SETTINGS, Schedule, ScheduleBench

CONFIG = config_of({"icu.slots": 16})
DEPTH = 5


class Slotted(wiring.Component):
    """The queue, and a stream of slots that come back; one comes back only when it has been handed out."""

    def __init__(self):
        self._queue = PatchQueue(config=CONFIG, depth=DEPTH)
        self.latency = self._queue.latency
        super().__init__({"i": self._queue.signature.members["i"], "o": self._queue.signature.members["o"],
                          "i_free": In(stream.Signature(0))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.queue = queue = self._queue
        wiring.connect(m, wiring.flipped(self.i), queue.i)
        wiring.connect(m, queue.o, wiring.flipped(self.o))
        m.d.comb += [self.i_free.ready.eq(queue.waiting != 0), queue.free.eq(self.i_free.valid & self.i_free.ready)]
        return m


COMPONENT = Slotted()
BENCH = ScheduleBench(COMPONENT, ["i", "i_free"], ["o"])


def item(patch):
    return {"patch": patch, "surface": -patch, "vertex": [patch, 2 * patch, 3 * patch]}


def run(vertex_stalls, free_stalls):
    """Every vertex comes out once, with its slot and index; no slot is handed out twice."""
    patches = len(vertex_stalls) // 4
    vertices = [(idle, item(k // 4)) for k, idle in enumerate(vertex_stalls[:4 * patches])]
    free = [(idle, 0) for idle in (*free_stalls, *[0] * patches)][:patches]
    came = BENCH.run(Schedule(items={"i": vertices, "i_free": free}, stalls={}))["o"]
    assert came == [{"slot": k // 4 % CONFIG.icu.slots, "index": k % 4, "item": vertices[k][1]}
                    for k in range(4 * patches)]
    entered, freed = BENCH.cycles["o"], BENCH.cycles["i_free"]
    for k, at in enumerate(entered[::4]):
        # Slots that came back in an earlier cycle can be handed out again.
        assert k - sum(back < at for back in freed) < CONFIG.icu.slots
    return entered, freed


def test_one_vertex_per_cycle():
    entered, _ = run([0] * 120, [])
    assert {b - a for a, b in pairwise(BENCH.cycles["i"])} == {b - a for a, b in pairwise(entered)} == {1}
    assert entered[0] - BENCH.cycles["i"][0] == COMPONENT.latency


def test_vertices_wait_for_a_slot_and_a_patch_is_not_cut():
    """With no slot left the queue fills up; a slot lets four vertices pass."""
    count = 4 * (CONFIG.icu.slots + 4)
    entered, freed = run([0] * count, [300, 30, 30])
    slots = CONFIG.icu.slots
    assert sum(at < freed[0] for at in entered) == 4 * slots
    assert sum(at < freed[0] for at in BENCH.cycles["i"]) == 4 * slots + DEPTH
    for k in range(2):
        assert entered[4 * (slots + k):4 * (slots + k + 1)] == list(range(freed[k] + 1, freed[k] + 5))


IDLE = st.lists(st.sampled_from((0, 0, 0, 0, 0, 1, 4)), min_size=1, max_size=9)
COVERAGE = Coverage(["all slots taken", "vertices wait", "slot comes back while another one is handed out",
                     "slot comes back while the queue waits", "vertex waits inside a patch"])


def test_any_stalls():
    @SETTINGS
    @given(st.sampled_from((3, 18, 24)), IDLE, st.sampled_from((0, 100, 200)), IDLE)
    def drawn(patches, vertex_stalls, before, free_stalls):
        entered, freed = run(list(islice(cycle(vertex_stalls), 4 * patches)),
                             [before, *islice(cycle(free_stalls), patches)])
        taken = [k - sum(back < at for back in freed) + 1 for k, at in enumerate(entered[::4])]
        waits = [b - a for a, b in zip(BENCH.cycles["i"], entered, strict=True)]
        COVERAGE.hit_all({
            "all slots taken": max(taken) == CONFIG.icu.slots, "vertices wait": max(waits) > COMPONENT.latency,
            "slot comes back while another one is handed out": bool(set(entered[::4]) & set(freed)),
            "slot comes back while the queue waits": any(
                entered[4 * (k + CONFIG.icu.slots)] == back + 1 for k, back in enumerate(freed[:-CONFIG.icu.slots])),
            "vertex waits inside a patch": any(b - a > 1 for k, (a, b) in enumerate(pairwise(entered)) if k % 4 != 3)})

    drawn()
    COVERAGE.check()
