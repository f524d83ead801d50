"""Work count: items in flight. tb/formal/memsys/test_work_count.py proves that ``empty`` is never early."""

import pytest

from hw.memsys.patches.work_count import WorkCount
from tb.lib.bench import Bench

SIZES = {"enters": 1, "leaves": 1, "most": 1}
MOST = 9


class TestWorkCount(Bench):
    component, arguments, variants = WorkCount, {"enters": 3, "leaves": 2, "most": MOST}, ({},)

    def model(self, config):
        """Items that leave are counted a cycle later than those that enter."""
        level, empty, left, self.inside = 0, 1, 0, 0
        given = yield
        while True:
            entered, outputs = given.enters.bit_count(), {"level": level, "empty": empty}
            empty = level == left and not entered
            level, left = level - left + entered, given.leaves.bit_count()
            self.inside += entered - left
            given = yield outputs

    def drive(self, given, random):
        """As many as there are, and as the count holds."""
        while given.enters.bit_count() > MOST - 2 - self.inside:
            given.enters &= given.enters - 1
        while given.leaves.bit_count() > self.inside:
            given.leaves &= given.leaves - 1


@pytest.mark.parametrize("name", SIZES)
def test_sizes_must_be_numbers_of_something(name):
    with pytest.raises(ValueError, match=f"^{name.capitalize()} must be at least 1, not 0$"):
        WorkCount(**{**SIZES, name: 0})
