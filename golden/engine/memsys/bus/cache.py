"""A cache: hit or miss of each request, its line, and the key that it evicts."""

import numpy as np

from golden.base.errors import InputError
from golden.engine.config import Memsys
from golden.engine.memsys.bus.cache_policy import CachePolicy
from golden.engine.memsys.bus.lfu_placement import LfuPlacement
from golden.engine.memsys.bus.set_placement import SetPlacement

__all__ = ["Cache"]


class Cache:
    """One interface for all policies. A line holds one record, of a cell or of a patch.

    A request allocates its line at once, while the fetch is in flight: a second request for the same key is a hit.

    Parameters
    ----------
    policy
        Placement and replacement.
    lines
        Lines of the cache, a power of two.
    ways, lfu_lines, lfu_count_bits
        See `golden.engine.config.Memsys`. ``LFU`` uses the first ``lfu_lines`` lines only.

    Members
    -------
    hits, misses
        Counts since construction or `clear`.

    Raises
    ------
    InputError
        Fewer lines than ways, or a number that is no power of two.
    """

    def __init__(self, policy: CachePolicy, *, lines: int, ways: int = 4, lfu_lines: int = 64, lfu_count_bits: int = 6):
        if policy is CachePolicy.LRU and lines < ways:
            raise InputError(f"cache: Lines must be at least {ways}, the ways, not {lines!r}")
        if policy is CachePolicy.LFU:
            self._placement = LfuPlacement(lines=min(lines, lfu_lines), count_bits=lfu_count_bits)
        else:
            ways = ways if policy is CachePolicy.LRU else 1
            self._placement = SetPlacement(sets=lines // ways, ways=ways)
        self.hits = self.misses = 0

    @classmethod
    def of(cls, memsys: Memsys, *, lines: int) -> "Cache":
        """The cache of a configuration."""
        return cls(CachePolicy[memsys.cache_policy.upper()], lines=lines, ways=memsys.cache_ways,
                   lfu_lines=memsys.lfu_lines, lfu_count_bits=memsys.lfu_count_bits)

    def clear(self) -> None:
        """Invalidate all lines and reset the counts."""
        self._placement.clear()
        self.hits = self.misses = 0

    def access(self, keys) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Serve requests in their order.

        Parameters
        ----------
        keys
            N int from 0: numbers of cells or patches.

        Returns
        -------
        tuple
            N bool: the request is a hit; N int64: its line; N int64: the key that it evicts, or -1.
        """
        hit, line, victim = self._placement.access(keys)
        self.hits += int(hit.sum())
        self.misses += int((~hit).sum())
        return hit, line, victim
