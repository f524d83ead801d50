"""When a bank is swept; `tb.icu.test_read_out` has its updates, reads and resets."""

from itertools import pairwise

from hw.icu.ray_memory import RayMemory
from tb.lib.configurations import config_of
from tb.lib.schedules import Schedule, ScheduleBench

RAYS = 64


def test_a_bank_is_swept_only_when_its_tags_run_out():
    config = config_of({"icu.rays": RAYS, "icu.generation_bits": 2})
    bench = ScheduleBench(RayMemory(config=config, tag=10), ["i_start"], [], idle_limit=RAYS + 16)
    bench.run(Schedule(items={"i_start": [(0, 0)] * 14}), rays=RAYS)
    cycles, sweep = bench.cycles["i_start"], RAYS + 1
    assert cycles[0] - bench.trace.offered["i_start"][0] == RAYS
    # Two banks by turns, three generations each.
    assert [later - earlier for earlier, later in pairwise(cycles)] == [
        sweep, *[1] * 4, sweep, sweep, *[1] * 4, sweep, sweep]
