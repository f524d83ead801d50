"""Compiled cache lines hit and miss as golden's cache does."""

import numpy as np
import pytest

from golden.engine.config import Memsys
from golden.engine.memsys.bus.cache import Cache
from radiosity.machines.engine.cache_lines import access_line, cache_lines


@pytest.mark.parametrize("policy", ["direct", "lru", "lfu"])
def test_hits_are_those_of_the_cache(policy):
    """Of keys that are used more often in a row than a line counts."""
    memsys, draw = Memsys(cache_policy=policy, lfu_lines=4, lfu_count_bits=2), np.random.default_rng(4)
    keys = np.repeat(draw.zipf(1.3, 1500) % 200, draw.choice((1, 1, 2, 6), 1500))
    lines = cache_lines(memsys, lines=32)
    found = [access_line(lines, int(key)) for key in keys]
    hit, _, _ = Cache.of(memsys, lines=32).access(keys)
    assert 0.1 < hit.mean() < 0.9
    assert np.array_equal(found, hit)
