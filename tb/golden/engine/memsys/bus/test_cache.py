"""Each policy against an independent model of its rule, one access at a time."""

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.engine.config import Memsys
from golden.engine.memsys.bus.cache import Cache
from golden.engine.memsys.bus.cache_policy import CachePolicy
from golden.engine.memsys.bus.reference_strings import interleaved

STRINGS = {
    "random": lambda random: random.integers(0, 40, 3000),
    "skewed": lambda random: np.minimum(random.geometric(0.06, 3000), 200),
    "loop": lambda random: np.tile(np.arange(37), 80),
    "far apart": lambda random: random.integers(0, 40, 1000) << 12,
}


def rule(policy, keys, lines, ways, top):
    """Line of each access, and its previous content."""
    content, last, count, filled = [-1] * lines, [-1] * lines, [0] * lines, -1
    for now, key in enumerate(int(key) for key in keys):
        candidates = {CachePolicy.DIRECT: [key % lines], CachePolicy.LFU: range(lines),
                      CachePolicy.LRU: range(key % (lines // ways), lines, lines // ways)}[policy]
        held = [line for line in candidates if content[line] == key]
        if held:
            chosen = held[0]
        elif policy is CachePolicy.LFU:
            chosen = min(candidates, key=lambda line: (count[line], (line - filled - 1) % lines))
            filled, count[chosen] = chosen, 0
        else:
            chosen = min(candidates, key=lambda line: last[line])
        yield bool(held), chosen, -1 if held else content[chosen]
        content[chosen], last[chosen], count[chosen] = key, now, min(count[chosen] + 1, top)


@pytest.mark.parametrize("lines", [4, 16, 32])
@pytest.mark.parametrize("string", STRINGS)
@pytest.mark.parametrize("policy", CachePolicy)
def test_access_by_access(policy, string, lines):
    keys = STRINGS[string](np.random.default_rng(1))
    cache = Cache(policy, lines=lines, ways=4, lfu_lines=64, lfu_count_bits=3)
    expected = [np.array(column) for column in zip(*rule(policy, keys, lines, 4, 7), strict=True)]
    # As one string, and in pieces.
    for pieces in (1, 7):
        cache.clear()
        came = [np.concatenate(parts) for parts in
                zip(*(cache.access(part) for part in np.array_split(keys, pieces)), strict=True)]
        for got, required in zip(came, expected, strict=True):
            np.testing.assert_array_equal(got, required)
        assert (cache.hits, cache.misses) == (expected[0].sum(), (~expected[0]).sum())


def test_the_configuration_says_the_policy_and_the_sizes():
    keys = np.random.default_rng(2).integers(0, 64, 4000)
    seen = set()
    for changes in ({}, {"cache_policy": "direct"}, {"cache_policy": "lfu"}, {"cache_ways": 2},
                    {"cache_policy": "lfu", "lfu_lines": 8}, {"cache_policy": "lfu", "lfu_count_bits": 2}):
        _, line, victim = Cache.of(Memsys(**changes), lines=32).access(keys)
        seen.add((*line.tolist(), *victim.tolist()))
    assert len(seen) == 6


@pytest.mark.parametrize(("policy", "lines"), [(CachePolicy.LRU, 2), (CachePolicy.DIRECT, 12), (CachePolicy.LFU, 0)])
def test_sizes_that_cannot_be(policy, lines):
    with pytest.raises(InputError, match=r"^cache: (Lines|Sets)"):
        Cache(policy, lines=lines)


def test_clusters_request_in_round_robin_order_and_begin_a_frustum_together():
    frusta = ((np.array([1, 2, 3]), np.array([4])), (np.array([5]), np.array([6, 7])))
    np.testing.assert_array_equal(interleaved(frusta), [1, 4, 2, 3, 5, 6, 7])
    resident = np.isin(np.arange(8), [2, 6])
    np.testing.assert_array_equal(interleaved(frusta, resident=resident), [1, 4, 3, 5, 7])
