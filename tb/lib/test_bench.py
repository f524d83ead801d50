"""A declared testbench notices what each of its regimes is for."""

import re

import pytest
from amaranth.hdl import Module, Signal
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from tb.lib.bench import Bench, Case, Vectors
from tb.lib.responder import responder
from tb.lib.runner import SIMULATORS, Simulation, recorded
from tb.lib.stages import Elastic, passage


class Doubled(wiring.Component):
    """Twice a number, with at most one fault; it requests the second half of each number at ``o_ask``.

    Timing
    ------
    Latency: ``1`` cycles after the answer.
    """

    latency = 1

    def __init__(self, fault=""):
        flows, waits = stream.Signature(8, always_ready=True), stream.Signature(8)
        super().__init__({"i": In(waits), "o": Out(waits), "o_ask": Out(flows), "i_answer": In(flows)})
        self._fault = fault

    def elaborate(self, platform):
        m = Module()
        busy, valid = Signal(), Signal(reset_less=self._fault == "reset")
        late = Signal()
        m.d.comb += [self.i.ready.eq(~busy), self.o_ask.valid.eq(self.i.valid & ~busy),
                     self.o_ask.payload.eq(self.i.payload),
                     self.o.valid.eq(late if self._fault == "latency" else valid)]
        wrong = (self.i_answer.payload == 77) if self._fault == "result" else 0
        m.d.sync += late.eq(valid & ~(self.o.valid & self.o.ready))
        with m.If(self.i.valid & ~busy):
            m.d.sync += [busy.eq(1), self.o.payload.eq(self.i.payload)]
        with m.If(self.i_answer.valid):
            m.d.sync += [valid.eq(1), self.o.payload.eq(self.o.payload + self.i_answer.payload + wrong)]
        with m.If(valid & (self.o.ready | (self.o.payload > 150 if self._fault == "stall" else 0)) & self.o.valid):
            m.d.sync += [valid.eq(0), busy.eq(0)]
        return m


class DoubledBench(Bench):
    fault, variants, splits = "", ({},), False

    def make(self, config):
        return Doubled(self.fault)

    def vectors(self, config):
        return Vectors(inputs={"i": list(range(100))}, expected={"o": [2 * k for k in range(100)],
                                                                 "o_ask": list(range(100))})

    @responder("o_ask", "i_answer", after=2)
    def answer(self, value):
        return [value]

    def predict(self, given, trace, component, config):
        """A number at a time."""
        taken, answers = trace.cycles["i"], trace.offered["i_answer"]
        _, left = passage([Elastic(component.latency, 1)], answers, trace.stalled["o"])
        begins = [max(offered, last + 1) for offered, last in zip(trace.offered["i"], [0, *left], strict=False)]
        assert len(taken) == len(answers)
        return {"i": begins, "o_ask": begins, "o": left}


class FaultyBench(DoubledBench):
    def __init__(self, fault=""):
        self.fault = fault


class TestDoubled(DoubledBench):
    pass


@pytest.mark.parametrize(("fault", "message"), [
    ("result", "item 77 of 100: o is 155, not 154"),
    ("latency", "o: item 0 of 100 is transferred in cycle"), ("stall", "o: an offer must stay")])
def test_faults_are_noticed_in_amaranth(fault, message):
    with pytest.raises(AssertionError, match=f"^{re.escape(message)}"):
        FaultyBench(fault).test_in_amaranth({})


class Stale(DoubledBench):
    fault = "reset"


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_what_survives_a_reset_is_noticed(simulator):
    with recorded() as runs:
        Stale().simulate(simulator)
    (run,) = runs
    assert Simulation(run.text, simulator).run(run.module, ("resets_in_flight",), "bench-stale", 1, run.given)


def test_a_field_without_expectation_may_have_any_value():
    bench = FaultyBench("result")
    bench.cases = {"some": Case(lambda config: Vectors(
        inputs={"i": [76, 77]}, expected={"o": [152, None]}), timed=False)}
    bench.test_in_amaranth({})
