"""Groups come apart into their rays, in order, one per cycle."""

import random
from itertools import pairwise

from amaranth.lib.data import StructLayout
from hypothesis import given
from hypothesis import strategies as st

from golden.config import PRESETS
from hw.ctu.ctu_formats import GRID_GROUP
from hw.ctu.group_split import GroupSplit
from tb.lib.schedules import SETTINGS, Schedule, ScheduleBench, payloads, schedules
from tb.lib.timing import documented_latency

RAY = StructLayout({"ray": 12, "column": 10, "stage": 4})
SPLIT = GroupSplit(RAY)
BENCH = ScheduleBench(SPLIT, watched=["leaves"])


def check(schedule):
    groups = schedule.values("i")
    assert BENCH.run(schedule)["o"] == [
        {**first, "ray": (first["ray"] + k) % (1 << 12), "column": (first["column"] + k) % (1 << 10)}
        for first, count in ((group["first"], group["count"]) for group in groups) for k in range(count)]
    assert sum(BENCH.history["leaves"]) == len(groups), "each group must free its entry once"


@SETTINGS
@given(schedules({"i": st.fixed_dictionaries({"first": payloads(RAY), "count": st.integers(1, GRID_GROUP)})}, ["o"]))
def test_every_ray_once_and_in_order(schedule):
    check(schedule)


def test_a_ray_per_cycle_after_the_latency():
    count = random.Random(4)
    check(Schedule(items={"i": [(0, {"first": {"ray": 30 * k, "column": k, "stage": k % 16},
                                     "count": count.randint(1, GRID_GROUP)}) for k in range(100)]}))
    left = BENCH.cycles["o"]
    assert left[0] - BENCH.cycles["i"][0] == SPLIT.latency == documented_latency(GroupSplit, PRESETS["tiny"])
    assert {b - a for a, b in pairwise(left)} == {1}
