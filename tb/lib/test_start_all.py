import pytest

from hw.lib.start_all import StartAll
from tb.lib.bench import Bench

COUNT = 3


class TestStartAll(Bench):
    component, arguments, variants = StartAll, {"count": COUNT}, ({},)

    def model(self, config):
        """The units that have not begun, and whether a start is on its way."""
        waits, runs = set(), False
        given = yield
        while True:
            ready = runs and not waits
            outputs = {"i": ready, **{f"o__{k}": 0 if k in waits else None for k in range(COUNT)}}
            waits = {k for k in waits if not getattr(given, f"o__{k}")}
            if given.i is not None and not runs:
                waits = {k for k in range(COUNT) if given.which >> k & 1}
            runs = given.i is not None and not ready
            given = yield outputs


@pytest.mark.parametrize(("count", "error"), [(0, ValueError), ("2", TypeError)])
def test_count_must_be_a_number_of_units(count, error):
    with pytest.raises(error, match=f"^Count must be at least 1, not {count!r}$"):
        StartAll(count=count)
