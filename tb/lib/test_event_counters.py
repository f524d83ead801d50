import pytest

from hw.lib.event_counters import EventCounters
from tb.lib.bench import Bench

EVENTS, BITS = {"one": 1, "some": 5}, 6


class TestEventCounters(Bench):
    component, arguments, variants = EventCounters, {"events": EVENTS, "bits": BITS}, ({},)

    def model(self, config):
        """Events pass a register, then they are added, and wrap; those that a clear meets are lost."""
        events = counters = dict.fromkeys(EVENTS, 0)
        given = yield
        while True:
            outputs = {"counters": counters}
            counters = {name: 0 if given.clear else (counters[name] + events[name]) % (1 << BITS) for name in EVENTS}
            events = given.events
            given = yield outputs

    def drive(self, given, random):
        """Counters wrap between most of the clears."""
        given.clear = random.random() < 0.02


@pytest.mark.parametrize(("bits", "error"), [(0, ValueError), (None, TypeError)])
def test_init_wrong_bits(bits, error):
    with pytest.raises(error, match=f"^Bits must be at least 1, not {bits}$"):
        EventCounters(EVENTS, bits=bits)
