"""Where a cache puts what it fetches."""

from amaranth.lib import enum

__all__ = ["CachePolicy"]


class CachePolicy(enum.Enum, shape=2):
    """Placement and replacement, see `golden.engine.memsys.bus.cache_policy.CachePolicy`."""

    DIRECT = 0
    LRU = 1
    LFU = 2
