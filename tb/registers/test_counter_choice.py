"""Which counter's value is reported."""

import pytest

from hw.registers.counter_choice import CounterChoice
from tb.lib.bench import Bench

GROUPS = 1, 5, 8, 3
COUNT = sum(GROUPS)


class TestCounterChoice(Bench):
    component, arguments, variants = CounterChoice, {"groups": GROUPS, "number_bits": 5}, ({},)

    def model(self, config):
        """A counter's value in the cycle after its number, three cycles after that number."""
        number = chosen = shown = None
        given = yield
        while True:
            outputs, shown = {"count": shown}, chosen
            chosen = given.counts[number] if number is not None and number < COUNT else None
            number = given.counter
            given = yield outputs


class TestMoreNumbers(TestCounterChoice):
    arguments = {"groups": GROUPS, "number_bits": 6}
    test_in_the_simulator = None


def test_init_wrong_number_bits():
    with pytest.raises(ValueError, match=f"^Number bits must be enough for {COUNT} counters, not 4$"):
        CounterChoice(groups=GROUPS, number_bits=4)
