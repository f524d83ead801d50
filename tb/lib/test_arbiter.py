"""Arbiters and their rules, cycle by cycle."""

import pytest
from amaranth.lib.data import StructLayout

from hw.lib import longest_waiting, round_robin
from hw.lib.arbiter import Arbiter, ArbiterPolicy
from tb.lib.bench import Bench
from tb.lib.grants import LongestWaiting, RoundRobin

SHAPE = StructLayout({"low": 4, "high": 4})
COUNT = 3
REQUESTS = 4


class TestArbiter(Bench):
    component, variants, rule = Arbiter, ({},), RoundRobin
    arguments = {"shape": SHAPE, "count": COUNT, "policy": ArbiterPolicy.ROUND_ROBIN}

    def model(self, config):
        """An item enters the register when that is free; requests age while it is not."""
        rule, item = self.rule(), None
        given = yield
        while True:
            requests = [k for k in range(COUNT) if getattr(given, f"i__{k}") is not None]
            granted, advances = rule.grant(requests, requests), item is None or given.o
            outputs = {"o": item} | {f"i__{k}": advances and k == granted for k in range(COUNT)}
            if advances:
                item = None
                if requests:
                    rule.accept(granted)
                    item = {"source": granted, "item": getattr(given, f"i__{granted}")}
            given = yield outputs


class TestOldestFirst(TestArbiter):
    rule = LongestWaiting
    arguments = {**TestArbiter.arguments, "policy": ArbiterPolicy.LONGEST_WAITING}


class TestRoundRobin(Bench):
    component, arguments, variants, rule = round_robin.RoundRobin, {"count": REQUESTS}, ({},), RoundRobin

    def model(self, config):
        """A request that is not eligible may age too."""
        rule = self.rule()
        given = yield
        while True:
            requests, eligible = ([k for k in range(REQUESTS) if bits >> k & 1]
                                  for bits in (given.request, given.eligible))
            granted = rule.grant(requests, eligible)
            if given.accept:
                rule.accept(granted)
            given = yield {"grant": 0 if granted is None else 1 << granted}

    def drive(self, given, random):
        """Most requests stay; only what requests is eligible, and only a grant is accepted."""
        self.before = given.request = given.request & random.getrandbits(REQUESTS) | getattr(self, "before", 0) & (
            random.getrandbits(REQUESTS) | random.getrandbits(REQUESTS))
        given.eligible &= given.request
        given.accept = bool(given.eligible) and random.random() < 0.7


class TestLongestWaiting(TestRoundRobin):
    component, rule = longest_waiting.LongestWaiting, LongestWaiting


@pytest.mark.parametrize(("count", "error"), [(0, ValueError), ("2", TypeError)])
def test_init_wrong_count(count, error):
    with pytest.raises(error, match=f"^Count must be at least 1, not {count!r}$"):
        Arbiter(SHAPE, count=count)


def test_init_wrong_policy():
    with pytest.raises(TypeError, match=r"^Policy must be an ArbiterPolicy, not 1$"):
        Arbiter(SHAPE, count=2, policy=1)
