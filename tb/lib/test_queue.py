import pytest
from amaranth.lib.data import StructLayout

from hw.lib.queue import Queue
from tb.lib.bench import Bench, Vectors

SHAPE = StructLayout({"number": 8, "inverted": 8})
ITEMS = [{"number": k, "inverted": ~k} for k in range(100)]


class TestQueue(Bench):
    """`tb.formal.lib.test_queue` proves its behaviour in all cycles."""

    component, arguments, variants = Queue, {"shape": SHAPE, "depth": 5}, ({},)

    def vectors(self, config):
        return Vectors(inputs={"i": ITEMS}, expected={"o": ITEMS})


@pytest.mark.parametrize(("depth", "error"), [(0, ValueError), (-1, ValueError), (2.0, TypeError)])
def test_init_wrong_depth(depth, error):
    with pytest.raises(error, match=f"^Depth must be at least 1, not {depth!r}$"):
        Queue(SHAPE, depth=depth)
