import random

import pytest

from hw.lib.event_counters import EventCounters
from hw.lib.payload import unpack
from tb.lib.configurations import config_of
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.timing import documented_latency

EVENTS, BITS, CYCLES = {"one": 1, "some": 5}, 6, 200


def test_counters_are_the_sums_of_their_events_and_wrap():
    counters, draw = EventCounters(EVENTS, bits=BITS), random.Random(1)
    events = [{"one": draw.getrandbits(1), "some": draw.getrandbits(5)} for _ in range(CYCLES)]
    clears = [cycle % 90 == 60 for cycle in range(CYCLES)]
    # Events of each cycle are in the counters after the latency; a clear takes effect a cycle after it.
    latency = documented_latency(EventCounters, config_of({}))
    assert counters.latency == latency
    expected = [dict.fromkeys(EVENTS, 0)] * latency
    for cycle in range(CYCLES - latency):
        last = expected[-1]
        expected.append({name: 0 if clears[cycle + latency - 1] else (last[name] + events[cycle][name]) % (1 << BITS)
                         for name in EVENTS})
    bench = ScheduleBench(counters, idle_limit=CYCLES, watched=["counters"])
    bench.run(Schedule(items={}), events=iter(events), clear=iter(clears))
    shape = counters.counters.shape()
    assert [unpack(shape, bits) for bits in bench.history["counters"]] == expected


@pytest.mark.parametrize(("bits", "error"), [(0, ValueError), (None, TypeError)])
def test_init_wrong_bits(bits, error):
    with pytest.raises(error, match=f"^Bits must be at least 1, not {bits}$"):
        EventCounters(EVENTS, bits=bits)
