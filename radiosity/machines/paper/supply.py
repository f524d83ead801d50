"""Supply: where the clusters of the paper's machine get patches."""

import enum

__all__ = ["Supply"]


class Supply(enum.Enum):
    """Who moves a patch, and what a cluster's memory is used for.

    ``PUSHED``: the host sends tags, then resident sets, which are one half of the memory; the other half is a cache.
    ``MAIN``: the host sends tags; there is no memory, and each reference goes to main memory. ``PULLED``: no tags; all
    of the memory is a cache.
    """

    PUSHED = "pushed"
    PULLED = "pulled"
    MAIN = "main"
