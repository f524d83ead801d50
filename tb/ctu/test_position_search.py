import numpy as np
import pytest

from golden.config import PRESETS
from hw.ctu.ctu_formats import CtuFormats
from hw.ctu.position_search import PositionSearch
from tb.lib.schedules import Schedule, ScheduleBench
from tb.lib.timing import documented_latency

CONFIG = PRESETS["tiny"]
FORMATS = CtuFormats(CONFIG)
ENTRIES, SEARCHES = 120, 80
SPREAD = 900
# Of the bounds.
HIGHEST = (1 << FORMATS.position_bound.width - 1) - 1
BENCH = ScheduleBench(PositionSearch(formats=FORMATS, address=FORMATS.grid_row_address), idle_limit=60)


def searches(random, positions):
    """Parts of the table and bounds: random ones, one entry, all of it; on positions, and beyond all of them."""
    for number in range(SEARCHES):
        first = int(random.integers(ENTRIES))
        count = 1 if number % 7 == 3 else int(random.integers(1, ENTRIES - first, endpoint=True))
        if number % 7 == 5:
            first, count = 0, ENTRIES
        low, end = (int(value) for value in random.integers(-2 * SPREAD, 2 * SPREAD, 2))
        if number % 3 == 1:
            low, end = int(positions[first]), int(positions[first + count - 1]) + number % 2
        yield {"first": first, "count": count, "low": low, "end": end}


@pytest.mark.parametrize("stalls", [[], [(1, 2, 40)[number % 3] for number in range(SEARCHES)]])
def test_counts_of_what_is_less(stalls):
    random = np.random.default_rng(1)
    positions = np.sort(random.integers(-SPREAD, SPREAD, ENTRIES))
    positions[ENTRIES // 2:ENTRIES // 2 + 9] = positions[ENTRIES // 2]
    given = list(searches(random, positions))
    came = BENCH.run(Schedule(
        first={"i_write": [{"address": address, "position": int(position)}
                           for address, position in enumerate(positions)]},
        items={"i": [(0, search) for search in given]}, stalls={"o": stalls}))["o"]
    for search, found in zip(given, came, strict=True):
        part = positions[search["first"]:search["first"] + search["count"]]
        # The least and the most bound with as many below.
        bounds = np.concatenate([[-HIGHEST - 2], part, [HIGHEST]])
        for name in "low", "end":
            count = (part < search[name]).sum()
            assert found[name] == {"count": count, "least": bounds[count] + 1, "most": bounds[count + 1]}, search
    if not stalls:
        assert [b - a for a, b in zip(BENCH.cycles["i"], BENCH.cycles["o"], strict=True)] == [
            documented_latency(PositionSearch, CONFIG, count=search["count"]) for search in given]
