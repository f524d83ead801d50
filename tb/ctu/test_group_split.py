"""Groups come apart into their rays, in order, one per cycle."""

import random

from amaranth.lib.data import StructLayout

from hw.ctu.ctu_formats import GRID_GROUP
from hw.ctu.group_split import GROUPS, GroupSplit
from tb.lib.bench import Bench, Vectors
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.stages import Elastic, Expand

RAY = StructLayout({"ray": 12, "column": 10, "stage": 4})


class TestGroupSplit(Bench):
    component, arguments, variants, splits = GroupSplit, {"shape": RAY}, ({},), False

    def vectors(self, config):
        draw = random.Random(4)
        # Columns of a ring go on after the last one.
        groups = [{"first": {"ray": 30 * k, "column": draw.choice((k, 1023 - k % 3)), "stage": k % 16},
                   "count": draw.randint(1, GRID_GROUP)} for k in range(100)]
        return Vectors(inputs={"i": groups}, expected={"o": [
            {**group["first"], "ray": group["first"]["ray"] + k, "column": (group["first"]["column"] + k) % 1024}
            for group in groups for k in range(group["count"])]})

    def stages(self, component, config):
        return [Elastic(1, GROUPS), Expand(group["count"] for group in self.now.inputs["i"]), Elastic(1, 2)]


def test_each_group_frees_its_entry_once():
    groups = TestGroupSplit().vectors(None).inputs["i"]
    bench = ScheduleBench(GroupSplit(RAY), watched=["leaves"])
    bench.run(Schedule(items={"i": [(0, group) for group in groups]}, stalls={"o": [k % 7 for k in range(99)]}))
    assert sum(bench.history["leaves"]) == len(groups)
