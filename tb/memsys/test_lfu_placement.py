import re

import numpy as np
import pytest

from golden.memsys.lfu_placement import LfuPlacement as GoldenPlacement
from hw.memsys.lfu_placement import LfuPlacement
from tb.lib.configurations import config_of
from tb.lib.timing import documented_latency
from tb.memsys.placement_bench import STRINGS, TAGS, run

STARTS = 2


def make(lines, count_bits=3):
    return LfuPlacement(lines=lines, key=8, tag=range(TAGS), count_bits=count_bits)


@pytest.mark.parametrize("string", STRINGS)
@pytest.mark.parametrize(("lines", "count_bits"), [(2, 2), (4, 3), (16, 4)])
def test_access_by_access(lines, count_bits, string):
    draw = np.random.default_rng(5)
    strings = [STRINGS[string](draw, lines) for _ in range(STARTS)]
    placement = make(lines, count_bits)
    seen = run(placement, GoldenPlacement(lines=lines, count_bits=count_bits), strings, gaps=False, seed=1)
    # The answer to a hit comes a cycle after the one before it, that to a miss later.
    between = np.diff(seen["came"])
    hit = np.array(seen["hit"][1:])
    assert set(between[hit]) <= {1}
    assert set(between[~hit]) == {count_bits + 5}
    assert seen["came"][0] - seen["taken"][0] == placement.latency_of_miss
    assert placement.latency == documented_latency(LfuPlacement, config_of({"memsys.lfu_count_bits": count_bits}))


def test_access_by_access_with_gaps():
    draw = np.random.default_rng(6)
    seen = run(make(8), GoldenPlacement(lines=8, count_bits=3), [STRINGS["random"](draw, 8) for _ in range(2)],
               gaps=True, seed=2)
    assert len(set(seen["hit"])) == 2


def test_a_hit_comes_after_the_latency():
    placement = make(4)
    seen = run(placement, GoldenPlacement(lines=4, count_bits=3), [np.array([9] * 30)], gaps=False, seed=3)
    np.testing.assert_array_equal((np.array(seen["came"]) - seen["taken"])[-10:], placement.latency)


@pytest.mark.parametrize(("changes", "message"), [
    ({"lines": 128}, "Lines must be a power of two, from 2 to 64, not 128"),
    ({"lines": 12}, "Lines must be a power of two, from 2 to 64, not 12"),
    ({"count_bits": 0}, "Count bits must be at least 1, not 0")])
def test_init_wrong(changes, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        make(**{"lines": 8, **changes})
