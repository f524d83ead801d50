"""Placement and replacement policies of a cache."""

import enum

__all__ = ["CachePolicy"]


class CachePolicy(enum.Enum):
    """Placement and replacement.

    ``DIRECT``: line = key mod lines. ``LRU``: a set is key mod sets; the least recently used line of the set
    is evicted. ``LFU``: any line; the least frequently used one is evicted.

    Source: Shen 1993, section 5.3.7, for ``DIRECT`` and ``LFU``.
    """

    DIRECT = 0
    LRU = 1
    LFU = 2
