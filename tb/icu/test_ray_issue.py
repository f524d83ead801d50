from itertools import pairwise

import pytest
from hypothesis import given
from hypothesis import strategies as st

from hw.icu.icu_formats import IcuFormats
from hw.icu.ray_issue import RayIssue
from tb.lib.configurations import config_of
from tb.lib.coverage import Coverage
from tb.lib.schedules import SETTINGS, ScheduleBench, payloads, schedules
from tb.lib.timing import documented_latency

FIRST_COLUMN, FIRST_ROW = 9, 70


def rays(masks, config):
    """The rays of masks, lowest first; a mask without rays is an item without a ray."""
    side = config.icu.tile_bits
    lanes, last_index = 1 << side, (1 << config.icu.side_bits) - 1
    for mask in masks:
        found = [lane for lane in range(lanes * lanes) if mask["mask"] >> lane & 1]
        for lane in found:
            column, row = (mask["tile_column"] << side) + lane % lanes, (mask["tile_row"] << side) + lane // lanes
            yield {"slot": mask["slot"], "ray": mask["tile"] << 2 * side | lane, "is_ray": 1,
                   "column": column + FIRST_COLUMN & last_index, "row": row + FIRST_ROW & last_index,
                   "last": mask["last"] & (lane == found[-1])}
        if not found:
            yield {"slot": mask["slot"], "is_ray": 0, "last": mask["last"]}


def masks_of(config):
    """Masks of which many are empty, full, or of one ray."""
    shape, lanes = IcuFormats(config).tile_rays, 1 << 2 * config.icu.tile_bits
    mask = st.one_of(st.just(0), st.sampled_from((1, 1 << lanes - 1, (1 << lanes) - 1)),
                     st.integers(0, (1 << lanes) - 1))
    return st.builds(lambda item, mask: {**item, "mask": mask}, payloads(shape), mask)


@pytest.mark.parametrize("tile_bits", [1, 2, 3])
def test_every_ray_once_and_no_cycle_more(tile_bits):
    config = config_of({"icu.tile_bits": tile_bits})
    issue, full = RayIssue(config=config), (1 << (1 << 2 * tile_bits)) - 1
    bench = ScheduleBench(issue, ["i"], ["o"])
    coverage = Coverage(["no ray", "one ray", "all rays", "last with rays", "last without rays", "not the last",
                         "masks without a gap", "mask waits"])

    @SETTINGS
    @given(schedules({"i": masks_of(config)}, [], most=10))
    def run(schedule):
        came = bench.run(schedule, first_column=FIRST_COLUMN, first_row=FIRST_ROW)["o"]
        given = schedule.values("i")
        expected = list(rays(given, config))
        assert [{name: item[name] for name in required}
                for item, required in zip(came, expected, strict=True)] == expected
        # A mask of n rays takes max(n, 1) cycles, as soon as those of the mask before are over.
        taken = bench.cycles["i"]
        counts = [max(mask["mask"].bit_count(), 1) for mask in given]
        cycles, begins = [], []
        for count, cycle in zip(counts, taken, strict=True):
            begins.append(max([cycle + issue.latency, *(last + 1 for last in cycles[-1:])]))
            cycles += range(begins[-1], begins[-1] + count)
        assert bench.cycles["o"] == cycles
        coverage.hit_all({
            "no ray": [not mask["mask"] for mask in given],
            "one ray": [mask["mask"].bit_count() == 1 for mask in given],
            "all rays": [mask["mask"] == full for mask in given],
            "last with rays": [mask["last"] and mask["mask"] > 0 for mask in given],
            "last without rays": [mask["last"] and not mask["mask"] for mask in given],
            "not the last": [not mask["last"] for mask in given],
            "masks without a gap": [b - a == count for (a, b), count in zip(pairwise(begins), counts, strict=False)],
            "mask waits": [idle == 0 and b - a > 1 for (idle, _), (a, b) in zip(schedule.items["i"][1:],
                                                                                pairwise(taken), strict=True)]})

    run()
    coverage.check()
    assert issue.latency == documented_latency(RayIssue, config)
