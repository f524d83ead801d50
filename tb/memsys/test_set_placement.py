import re

import numpy as np
import pytest

from golden.memsys.set_placement import SetPlacement as GoldenPlacement
from hw.memsys.set_placement import SetPlacement
from tb.lib.configurations import config_of
from tb.lib.timing import documented_latency
from tb.memsys.placement_bench import STRINGS, TAGS, run

# Tags run out after one start, or do not.
STARTS = 2


def make(lines, ways, key=8, generation_bits=2):
    return SetPlacement(lines=lines, ways=ways, key=key, tag=range(TAGS), generation_bits=generation_bits)


@pytest.mark.parametrize("string", STRINGS)
@pytest.mark.parametrize(("lines", "ways", "direct", "generation_bits"), [
    (4, 1, 0, 1), (8, 2, 0, 2), pytest.param(16, 4, 0, 1, marks=pytest.mark.nightly), (16, 4, 1, 2)])
def test_access_by_access(lines, ways, direct, generation_bits, string):
    draw = np.random.default_rng(5)
    strings = [STRINGS[string](draw, lines) for _ in range(STARTS)]
    golden = GoldenPlacement(sets=lines, ways=1) if direct else GoldenPlacement(sets=lines // ways, ways=ways)
    placement = make(lines, ways, generation_bits=generation_bits)
    seen = run(placement, golden, strings, gaps=False, seed=1, ports={"direct": direct})
    assert len(set(seen["hit"])) == 2, "there must be hits and misses"
    assert placement.latency == documented_latency(SetPlacement, config_of({}))
    taken = np.array(seen["taken"])
    assert (np.diff(taken) == 1).all()
    np.testing.assert_array_equal(np.array(seen["came"]) - taken, placement.latency)


def test_access_by_access_with_gaps():
    draw = np.random.default_rng(6)
    strings = [STRINGS["random"](draw, 16) for _ in range(2)]
    run(make(16, 4), GoldenPlacement(sets=4, ways=4), strings, gaps=True, seed=2)


@pytest.mark.parametrize("key", [2, 3])
def test_all_keys_have_lines_of_their_own(key):
    draw = np.random.default_rng(7)
    keys = [draw.integers(0, 1 << key, 60) for _ in range(2)]
    seen = run(make(8, 2, key=key), GoldenPlacement(sets=4, ways=2), keys, gaps=False, seed=3)
    assert sum(not hit for hit in seen["hit"]) == 1 << key


@pytest.mark.parametrize(("changes", "message"), [
    ({"ways": 3}, "Ways must be 1, 2 or 4, not 3"),
    ({"lines": 4, "ways": 4}, "Lines must be a power of two, at least 8, not 4"),
    ({"lines": 24}, "Lines must be a power of two, at least 4, not 24")])
def test_init_wrong(changes, message):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}$"):
        make(**{"lines": 8, "ways": 2, **changes})
