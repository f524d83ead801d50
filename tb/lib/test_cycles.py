"""A testbench with a model notices an output that is wrong in one cycle, and a model that claims nothing."""

from types import MappingProxyType

import pytest

from hw.lib.queue import Queue
from tb.lib.bench import Bench

DEPTH = 3


class TestQueue(Bench):
    component, arguments, variants = Queue, {"shape": 8, "depth": DEPTH}, ({},)
    depth, claims = DEPTH, MappingProxyType({})

    def model(self, config):
        """An item leaves a cycle after it has entered, or later."""
        items = []
        given = yield
        while True:
            accepts, outputs = len(items) < self.depth, {"o": items[0] if items else None, "level": len(items)}
            if items and given.o:
                del items[0]
            items += [given.i] if accepts and given.i is not None else []
            given = yield outputs | {"i": accepts} | self.claims


def test_a_wrong_capacity_is_noticed():
    class Deeper(TestQueue):
        depth = DEPTH + 1

    with pytest.raises(AssertionError, match=r"^cycle \d+: i__ready is 0, not 1$"):
        Deeper().test_in_amaranth({})


@pytest.mark.parametrize(("level", "message"), [(None, "the model says nothing of level"), (2, "level is always 2")])
def test_each_output_is_compared_and_changes(level, message):
    class Silent(TestQueue):
        claims = MappingProxyType({"level": level})

    with pytest.raises(AssertionError, match=f"^{message}$"):
        Silent().test_in_amaranth({})
