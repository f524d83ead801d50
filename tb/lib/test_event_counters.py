import random

import pytest
from amaranth.sim import Simulator

from hw.lib.event_counters import EventCounters
from tb.lib.configurations import config_of
from tb.lib.timing import documented_latency

EVENTS = {"one": 1, "some": 5}


def test_counters_are_the_sums_of_their_events_and_wrap():
    counters, draw, seen, expected = EventCounters(EVENTS, bits=6), random.Random(1), [], []

    async def bench(ctx):
        now = last = {"one": 0, "some": 0}
        for cycle in range(200):
            events = {"one": draw.getrandbits(1), "some": draw.getrandbits(5)}
            ctx.set(counters.events, events)
            # A clear reaches the counters together with the events of the cycle before.
            clears = cycle % 90 == 60
            ctx.set(counters.clear, clears)
            seen.append({name: ctx.get(counters.counters[name]) for name in EVENTS})
            expected.append(dict(now))
            await ctx.tick()
            if clears:
                now = dict.fromkeys(now, 0)
            else:
                now = {name: (now[name] + last[name]) % 64 for name in now}
            last = events

    simulator = Simulator(counters)
    simulator.add_clock(1e-8)
    simulator.add_testbench(bench)
    simulator.run()
    assert seen == expected
    assert counters.latency == documented_latency(EventCounters, config_of({}))


@pytest.mark.parametrize(("bits", "error"), [(0, ValueError), (None, TypeError)])
def test_init_wrong_bits(bits, error):
    with pytest.raises(error, match=f"^Bits must be at least 1, not {bits}$"):
        EventCounters(EVENTS, bits=bits)
