import pytest
from amaranth.lib.data import StructLayout

from hw.lib.fork import Fork
from tb.lib.bench import Bench, Vectors
from tb.lib.stages import passage

SHAPE = StructLayout({"number": 8, "inverted": 8})
ITEMS = [{"number": k, "inverted": ~k} for k in range(100)]


class TestFork(Bench):
    """`tb.formal.lib.test_fork` proves its behaviour in all cycles."""

    component, arguments, variants = Fork, {"shape": SHAPE, "count": 3}, ({},)

    def vectors(self, config):
        return Vectors(inputs={"i": ITEMS}, expected={f"o__{k}": ITEMS for k in range(3)})

    def predict(self, given, trace, component, config):
        """An output that is ahead waits for the slowest one."""
        predicted = {"i": [], **{name: [] for name in given.expected}}
        for offered in trace.offered["i"]:
            for name in given.expected:
                predicted[name] += passage([], [offered], trace.stalled[name])[1]
            predicted["i"].append(max(predicted[name][-1] for name in given.expected))
        return predicted


def test_shape_is_kept():
    assert all(output.payload.shape() == SHAPE for output in Fork(SHAPE, count=3).o)


@pytest.mark.parametrize(("count", "error"), [(0, ValueError), (1.0, TypeError)])
def test_init_wrong_count(count, error):
    with pytest.raises(error, match=f"^Count must be at least 1, not {count!r}$"):
        Fork(SHAPE, count=count)
