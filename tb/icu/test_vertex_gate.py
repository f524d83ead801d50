from itertools import pairwise

from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out
from hypothesis import given
from hypothesis import strategies as st

from hw.icu.vertex_gate import VERTICES, VertexGate
from tb.lib.configurations import config_of
from tb.lib.schedules import SETTINGS, Schedule, ScheduleBench
from tb.lib.timing import documented_latency

CONFIG = config_of({})
PERIOD = 8


class Shuttered(wiring.Component):
    """A gate that is open in the cycles of a repeated pattern; ``begun``: whether a patch that begins may begin."""

    def __init__(self):
        self._gate = VertexGate(config=CONFIG)
        members = self._gate.signature.members
        super().__init__({"i": members["i"], "o": members["o"], "pattern": In(PERIOD),
                          "begun": Out(stream.Signature(1, always_ready=True))})
        self.latency = self._gate.latency

    def elaborate(self, platform):
        m = Module()
        m.submodules.gate = gate = self._gate
        wiring.connect(m, wiring.flipped(self.i), gate.i)
        wiring.connect(m, gate.o, wiring.flipped(self.o))
        cycle, was_offered = Signal(range(PERIOD)), Signal()
        m.d.comb += [gate.is_open.eq(self.pattern.bit_select(cycle, 1)), self.begun.valid.eq(gate.begins),
                     self.begun.payload.eq(gate.is_open | was_offered)]
        m.d.sync += [cycle.eq(cycle + 1), was_offered.eq(gate.o.valid & ~gate.o.ready)]
        return m


COMPONENT = Shuttered()
BENCH = ScheduleBench(COMPONENT, ["i"], ["o", "begun"], idle_limit=4 * PERIOD)


def vertices(stalls):
    return [(idle, {"patch": k // VERTICES, "surface": -k, "vertex": [k, 2 * k, 3 * k]})
            for k, idle in enumerate(stalls)]


@SETTINGS
@given(st.integers(1, 4).flatmap(lambda patches: st.lists(st.integers(0, 5), min_size=VERTICES * patches,
                                                           max_size=VERTICES * patches)),
       st.lists(st.integers(0, 9), max_size=12), st.integers(1, (1 << PERIOD) - 1))
def test_offers_stay_and_all_vertices_pass(idle, stalls, pattern):
    """Whenever the gate closes: the bench fails if an offer is withdrawn. Each patch begins once, with its vertex."""
    given_items = vertices(idle)
    came = BENCH.run(Schedule(items={"i": given_items}, stalls={"o": stalls}), pattern=pattern)
    assert came == {"o": [item for _, item in given_items], "begun": [1] * (len(given_items) // VERTICES)}
    assert BENCH.cycles["begun"] == BENCH.cycles["o"][::VERTICES]


def test_an_offer_is_not_withdrawn_when_the_gate_closes():
    came = BENCH.run(Schedule(items={"i": vertices([0] * VERTICES)}, stalls={"o": [20]}), pattern=1)
    assert len(came["o"]) == VERTICES


def test_a_closed_gate_begins_no_patch():
    """Patches pass only in the open cycle; the rest of a patch follows at once."""
    BENCH.run(Schedule(items={"i": vertices([0] * 3 * VERTICES)}, stalls={}), pattern=1)
    first = BENCH.cycles["o"][::VERTICES]
    assert {later - earlier for earlier, later in pairwise(first)} == {PERIOD}
    assert all(BENCH.cycles["o"][k + 3] - BENCH.cycles["o"][k] == 3 for k in range(0, 3 * VERTICES, VERTICES))
    assert COMPONENT.latency == documented_latency(VertexGate, CONFIG)
