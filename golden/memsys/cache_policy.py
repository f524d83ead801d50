"""Where a cache puts what it fetches."""

import enum

__all__ = ["CachePolicy"]


class CachePolicy(enum.Enum):
    """Placement and replacement.

    ``DIRECT``: line = key mod lines. ``LRU``: a set is key mod sets; of its lines the one goes that was used least
    recently. ``LFU``: any line; the one goes that was used least often.

    Source: Shen 1993, section 5.3.7, for ``DIRECT`` and ``LFU``.
    """

    DIRECT = 0
    LRU = 1
    LFU = 2
