# amaranth: UnusedElaboratable=no

import pytest
from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from hw.lib.fork import Fork
from hw.lib.queue import Queue
from tb.lib.block_bench import Vectors, check_in_simulator
from tb.lib.runner import SIMULATORS

SHAPE = StructLayout({"number": 8, "inverted": 8})
ITEMS = [{"number": k, "inverted": ~k} for k in range(100)]


class ForkedAndJoined(wiring.Component):
    """Two paths of different length and capacity, whose items meet again in pairs."""

    def __init__(self):
        super().__init__({"i": In(stream.Signature(SHAPE)),
                          "o": Out(stream.Signature(StructLayout({"short": SHAPE, "long": SHAPE})))})
        self.latency = 2

    def elaborate(self, platform):
        m = Module()
        m.submodules.fork = fork = Fork(SHAPE, count=2)
        short, first, second = queues = [Queue(SHAPE, depth=depth) for depth in (3, 2, 2)]
        m.submodules += queues
        wiring.connect(m, wiring.flipped(self.i), fork.i)
        for a, b in ((fork.o[0], short.i), (fork.o[1], first.i), (first.o, second.i)):
            wiring.connect(m, a, b)
        m.d.comb += self.o.valid.eq(short.o.valid & second.o.valid)
        for name, path in (("short", short), ("long", second)):
            m.d.comb += [self.o.payload[name].eq(path.o.payload), path.o.ready.eq(self.o.valid & self.o.ready)]
        return m


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    check_in_simulator("fork", lambda config: ForkedAndJoined(), lambda config: Vectors(
        items=ITEMS, expected={"o": [{"short": item, "long": item} for item in ITEMS]}), simulator=simulator)


def test_shape_is_kept():
    assert all(output.payload.shape() == SHAPE for output in Fork(SHAPE, count=3).o)


@pytest.mark.parametrize(("count", "error"), [(0, ValueError), (1.0, TypeError)])
def test_init_wrong_count(count, error):
    with pytest.raises(error, match=f"^Count must be at least 1, not {count!r}$"):
        Fork(SHAPE, count=count)
