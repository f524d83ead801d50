import pytest
from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from hw.lib.credit_gate import CreditGate
from hw.lib.pipeline import Pipeline
from hw.lib.queue import Queue
from tb.lib.bench import Bench, Vectors
from tb.lib.stages import Elastic

SHAPE = StructLayout({"number": 8, "inverted": 8})
ITEMS = [{"number": k, "inverted": ~k} for k in range(100)]


class Gated(wiring.Component):
    """A pipeline that cannot wait between a gate and a queue; it holds two items less than there are credits."""

    def __init__(self):
        super().__init__({"i": In(stream.Signature(SHAPE)), "o": Out(stream.Signature(SHAPE))})
        inside = stream.Signature(SHAPE, always_ready=True)
        self._in, self._out = inside.flip().create(), inside.create()
        self._pipeline = Pipeline(self._in, self._out)
        self._pipeline.output(self._out.payload, self._pipeline.delay(self._pipeline.input(self._in.payload), 4))
        self.latency, self.credits = self._pipeline.latency + 1, self._pipeline.latency + 2

    def elaborate(self, platform):
        m = Module()
        m.submodules.gate, m.submodules.queue = gate, queue = CreditGate(SHAPE, credits=self.credits), Queue(
            SHAPE, depth=self.credits)
        self._pipeline.add_to(m)
        wiring.connect(m, wiring.flipped(self.i), gate.i)
        wiring.connect(m, queue.o, wiring.flipped(self.o))
        m.d.comb += [gate.o.ready.eq(1), self._in.valid.eq(gate.o.valid), self._in.payload.eq(gate.o.payload),
                     queue.i.valid.eq(self._out.valid), queue.i.payload.eq(self._out.payload),
                     gate.i_return.valid.eq(queue.o.valid & queue.o.ready)]
        return m


class TestCreditGate(Bench):
    """`tb.formal.lib.test_credit_gate` proves its behaviour in all cycles."""

    component, variants = Gated, ({},)

    def latency(self, component, config):
        return component.latency

    def stages(self, component, config):
        return [Elastic(component.latency, component.credits)]

    def vectors(self, config):
        return Vectors(inputs={"i": ITEMS}, expected={"o": ITEMS})


@pytest.mark.parametrize(("credits", "error"), [(0, ValueError), (1.5, TypeError)])
def test_init_wrong_credits(credits, error):
    with pytest.raises(error, match=f"^Credits must be at least 1, not {credits!r}$"):
        CreditGate(SHAPE, credits=credits)
