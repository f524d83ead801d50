from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In

from hw.icu.patch_queue import PatchQueue
from tb.lib.bench import Bench, Vectors
from tb.lib.responder import responder
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.stages import Elastic, Gate, passage

DEPTH, SLOTS = 5, 16


class Slotted(wiring.Component):
    """The queue, and a stream of slots that are free again; each only when it has been allocated."""

    def __init__(self, config):
        self._queue = PatchQueue(config=config, depth=DEPTH)
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


class TestPatchQueue(Bench):
    """Every vertex comes out with its slot and index; the first one of a patch when a slot is free."""

    component, changes, variants, splits = Slotted, {"icu.slots": SLOTS}, ({},), False
    # Until all slots are free: the last answers, each behind a burst of stalls, or all behind the longest one.
    idle_limit = 90 + 300 + 40 * SLOTS

    def vectors(self, config):
        vertices = [{"patch": k // 4, "surface": -(k // 4), "vertex": [k, 2 * k, 3 * k]} for k in range(8 * SLOTS)]
        return Vectors(inputs={"i": vertices}, expected={"o": [
            {"slot": k // 4 % SLOTS, "index": k % 4, "item": vertex} for k, vertex in enumerate(vertices)]})

    @responder("o", "i_free", after=(40, 90))
    def free(self, vertex):
        """Patches take so long that all slots are taken."""
        return [0] * (vertex["index"] == 3)

    def latency(self, component, config):
        return component.latency

    def stages(self, component, config):
        return [Elastic(component.latency, DEPTH)]

    def predict(self, given, trace, component, config):
        """A slot that is free again can be allocated in the next cycle."""
        opens = [trace.cycles["i_free"][k // 4 - SLOTS] + 1 if k % 4 == 0 and k >= 4 * SLOTS else 0
                 for k in range(len(given.inputs["i"]))]
        accepted, left = passage([*self.stages(component, config), Gate(opens)], trace.offered["i"])
        return {"i": accepted, "o": left}


def test_vertices_wait_for_a_slot_and_a_patch_is_not_cut():
    """With no slot left the queue fills up; a slot lets four vertices pass."""
    bench = TestPatchQueue()
    config = bench.config()
    vertices, component = bench.vectors(config).inputs["i"], bench.make(config)
    run = ScheduleBench(component)
    run.run(Schedule(items={"i": [(0, vertex) for vertex in vertices],
                            "i_free": [(idle, 0) for idle in (300, 30, 30, *[0] * SLOTS)]}))
    entered, freed = run.cycles["o"], run.cycles["i_free"]
    assert sum(at < freed[0] for at in entered) == 4 * SLOTS
    assert sum(at < freed[0] for at in run.cycles["i"]) == 4 * SLOTS + DEPTH
    for k in range(2):
        assert entered[4 * (SLOTS + k):4 * (SLOTS + k + 1)] == list(range(freed[k] + 1, freed[k] + 5))
