# amaranth: UnusedElaboratable=no

import pytest
from amaranth.lib.data import StructLayout

from hw.lib.queue import Queue
from tb.lib.block_bench import Vectors, check_in_simulator
from tb.lib.runner import SIMULATORS

SHAPE = StructLayout({"number": 8, "inverted": 8})
ITEMS = [{"number": k, "inverted": ~k} for k in range(100)]


def vectors(config):
    return Vectors(items=ITEMS, expected={"o": ITEMS})


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_in_the_simulator(simulator):
    check_in_simulator("queue", lambda config: Queue(SHAPE, depth=5), vectors, simulator=simulator)


@pytest.mark.parametrize(("depth", "error"), [(0, ValueError), (-1, ValueError), (2.0, TypeError)])
def test_init_wrong_depth(depth, error):
    with pytest.raises(error, match=f"^Depth must be at least 1, not {depth!r}$"):
        Queue(SHAPE, depth=depth)
