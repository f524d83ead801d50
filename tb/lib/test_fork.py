# amaranth: UnusedElaboratable=no

import pytest
from amaranth.hdl import Module
from amaranth.lib import stream, wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.wiring import In, Out

from hw.lib.fork import Fork
from hw.lib.join import Join
from hw.lib.queue import Queue
from tb.lib.block_bench import Vectors, check_in_simulator
from tb.lib.runner import SIMULATORS

SHAPE = StructLayout({"number": 8, "inverted": 8})
ITEMS = [{"number": k, "inverted": ~k} for k in range(100)]


class ForkedAndJoined(wiring.Component):
    """Two ways, one longer and with more room than the other, and both together again."""

    def __init__(self):
        self._join = Join({"short": SHAPE, "long": SHAPE})
        super().__init__({"i": In(stream.Signature(SHAPE)), "o": Out(self._join.o.signature)})
        self.latency = 2

    def elaborate(self, platform):
        m = Module()
        m.submodules.fork, m.submodules.join = fork, join = Fork(SHAPE, count=2), self._join
        short, first, second = queues = [Queue(SHAPE, depth=depth) for depth in (3, 2, 2)]
        m.submodules += queues
        wiring.connect(m, wiring.flipped(self.i), fork.i)
        for a, b in ((fork.o[0], short.i), (short.o, join.i_short), (fork.o[1], first.i), (first.o, second.i),
                     (second.o, join.i_long)):
            wiring.connect(m, a, b)
        wiring.connect(m, join.o, wiring.flipped(self.o))
        return m


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    check_in_simulator("fork", lambda config: ForkedAndJoined(), lambda config: Vectors(
        items=ITEMS, expected={"o": [{"short": item, "long": item} for item in ITEMS]}), simulator=simulator)


def test_shape_is_kept():
    assert all(output.payload.shape() == SHAPE for output in Fork(SHAPE, count=3).o)
    assert Join({"a": SHAPE, "b": 3}).o.payload.shape() == StructLayout({"a": SHAPE, "b": 3})


@pytest.mark.parametrize(("count", "error"), [(0, ValueError), (1.0, TypeError)])
def test_init_wrong_count(count, error):
    with pytest.raises(error, match=f"^Count must be at least 1, not {count!r}$"):
        Fork(SHAPE, count=count)


def test_init_wrong_shapes():
    with pytest.raises(ValueError, match=r"^Shapes must be at least one, not \{\}$"):
        Join({})
