"""A cache: which of the requests are served from its lines, which line each one takes, and what goes for it."""

import numpy as np

from golden.config import Memsys
from golden.errors import InputError
from golden.memsys.cache_policy import CachePolicy
from golden.memsys.lfu_placement import LfuPlacement
from golden.memsys.set_placement import SetPlacement

__all__ = ["Cache"]


class Cache:
    """One interface for all policies. A line takes one record: a cell's, or a patch's.

    What has been asked for is in its line from then on, although it may still be on its way: a second request for it is
    a hit, and waits.

    Parameters
    ----------
    policy
        Where records are put.
    lines
        A power of two.
    ways, lfu_lines, lfu_count_bits
        See `golden.config.Memsys`. ``LFU`` uses the first ``lfu_lines`` of the lines and leaves the others empty.

    Members
    -------
    hits, misses
        Since it was made, or cleared.

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
        """Empty all lines, and count from 0 again."""
        self._placement.clear()
        self.hits = self.misses = 0

    def access(self, keys) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Requests one after the other.

        Parameters
        ----------
        keys
            N int from 0: numbers of cells or patches.

        Returns
        -------
        N each: whether it is a hit, the line, and the key that goes for it, or -1.
        """
        hit, line, victim = self._placement.access(keys)
        self.hits += int(hit.sum())
        self.misses += int((~hit).sum())
        return hit, line, victim

    @property
    def miss_ratio(self) -> float:
        """Misses over requests; 0 of none."""
        return self.misses / max(1, self.hits + self.misses)
