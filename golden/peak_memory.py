"""Memory of this process."""

import resource

__all__ = ["peak_memory"]


def peak_memory() -> int:
    """The most bytes that this process has had."""
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
