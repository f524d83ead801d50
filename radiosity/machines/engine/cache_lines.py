"""Cache lines: hit or miss of each access to a cache, in flat arrays that compiled functions change.

The rule is that of `golden.engine.memsys.bus.cache.Cache`.
"""

from typing import NamedTuple

import numpy as np

from golden.base.compiled import compiled
from golden.engine.config import Memsys
from golden.engine.memsys.bus.cache_policy import CachePolicy
from radiosity.machines.common.columns import columns

__all__ = ["CacheLines", "access_line", "cache_lines"]

_EMPTY = -1
# Numbers of a cache: whether use counts decide, their largest value, accesses so far, and the line that is filled next.
_Number = columns("_Number", "BY_COUNT TOP ACCESSES NEXT")


class CacheLines(NamedTuple):
    """The lines of a cache.

    Parameters
    ----------
    keys
        Sets x ways int64: the key of each line, -1 of an empty one.
    used
        The same of the last access to each line, or of its use count.
    numbers
        The rule, and the state of all lines.
    """

    keys: np.ndarray
    used: np.ndarray
    numbers: np.ndarray


def cache_lines(memsys: Memsys, *, lines: int) -> CacheLines:
    """An empty cache of so many lines, with the placement of a configuration."""
    policy = CachePolicy[memsys.cache_policy.upper()]
    is_lfu = policy is CachePolicy.LFU
    ways = {CachePolicy.LFU: min(lines, memsys.lfu_lines), CachePolicy.LRU: memsys.cache_ways}.get(policy, 1)
    shape = 1 if is_lfu else lines // ways, ways
    return CacheLines(np.full(shape, _EMPTY, dtype=np.int64), np.zeros(shape, dtype=np.int64),
                      np.array([is_lfu, (1 << memsys.lfu_count_bits) - 1, 0, 0], dtype=np.int64))


@compiled
def access_line(cache: CacheLines, key: int) -> bool:
    """Access a key, which is in a line from now on: whether it was before."""
    numbers, row = cache.numbers, key % len(cache.keys)
    numbers[_Number.ACCESSES] += 1
    ways = cache.keys.shape[1]
    for way in range(ways):
        if cache.keys[row, way] == key:
            cache.used[row, way] = (min(cache.used[row, way] + 1, numbers[_Number.TOP]) if numbers[_Number.BY_COUNT]
                                    else numbers[_Number.ACCESSES])
            return True
    # Of lines used as often, or never, the first one from the next line on.
    chosen = numbers[_Number.NEXT]
    for step in range(1, ways):
        way = (numbers[_Number.NEXT] + step) % ways
        if cache.used[row, way] < cache.used[row, chosen]:
            chosen = way
    cache.keys[row, chosen] = key
    cache.used[row, chosen] = 1 if numbers[_Number.BY_COUNT] else numbers[_Number.ACCESSES]
    if numbers[_Number.BY_COUNT]:
        numbers[_Number.NEXT] = (chosen + 1) % ways
    return False
