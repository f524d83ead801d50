from collections import defaultdict, deque

import pytest
from amaranth.lib.data import StructLayout

from hw.lib.arbiter import Arbiter, ArbiterPolicy
from tb.lib.bench import Bench, Vectors
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.stages import passage

SHAPE = StructLayout({"low": 4, "high": 4})
COUNT = 3
ITEMS = {k: [{"low": k, "high": number % 16} for number in range(24)] for k in range(COUNT)}


class TestArbiter(Bench):
    """Items of each source come in its order; while all request, in turn. `tb.formal.lib.test_arbiter` has proofs."""

    component, variants, splits = Arbiter, ({},), False
    arguments = {"shape": SHAPE, "count": COUNT, "policy": ArbiterPolicy.ROUND_ROBIN}

    def vectors(self, config):
        return Vectors(inputs={f"i__{k}": items for k, items in ITEMS.items()}, expected={})

    def is_over(self, given, came):
        return len(came["o"]) == sum(map(len, ITEMS.values()))

    def check(self, given, came):
        split = defaultdict(list)
        for item in self.values("o", came):
            split[item["source"]].append(item["item"])
        assert split == ITEMS

    def predict(self, given, trace, component, config):
        """Whichever is granted, one is in each cycle in which any requests and the item before can leave."""
        granted = sorted((cycle, name) for name in given.inputs for cycle in trace.cycles[name])
        waiting, offered = {name: deque(trace.offered[name]) for name in given.inputs}, []
        for _, name in granted:
            offered.append(min(times[0] for times in waiting.values() if times))
            waiting[name].popleft()
        accepted, left = passage(self.stages(component, config), offered, trace.stalled["o"])
        assert [cycle for cycle, _ in granted] == accepted
        return {"o": left}


class TestLongestWaiting(TestArbiter):
    arguments = {**TestArbiter.arguments, "policy": ArbiterPolicy.LONGEST_WAITING}
    test_in_the_simulator = None


@pytest.mark.parametrize(("policy", "order"), [(ArbiterPolicy.ROUND_ROBIN, [0, 1, 2, 0]),
                                               (ArbiterPolicy.LONGEST_WAITING, [0, 2, 1, 0])])
def test_who_came_first(policy, order):
    """While the output stalls with an item of input 0, inputs 2, 1 and 0 request, one after the other."""
    zero = {"low": 0, "high": 0}
    came = ScheduleBench(Arbiter(SHAPE, count=COUNT, policy=policy)).run(Schedule(
        items={"i__0": [(0, zero), (8, zero)], "i__1": [(6, zero)], "i__2": [(4, zero)]}, stalls={"o": [20]}))["o"]
    assert [item["source"] for item in came] == order


@pytest.mark.parametrize(("count", "error"), [(0, ValueError), ("2", TypeError)])
def test_init_wrong_count(count, error):
    with pytest.raises(error, match=f"^Count must be at least 1, not {count!r}$"):
        Arbiter(SHAPE, count=count)


def test_init_wrong_policy():
    with pytest.raises(TypeError, match=r"^Policy must be an ArbiterPolicy, not 1$"):
        Arbiter(SHAPE, count=2, policy=1)
