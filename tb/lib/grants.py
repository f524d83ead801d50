"""Who is granted, for golden models of units with arbiters."""

from collections.abc import Collection

__all__ = ["LongestWaiting", "RoundRobin"]


class RoundRobin:
    """The next request after the last one that was accepted."""

    def __init__(self):
        self._last = -1

    def grant(self, requests: Collection[int], eligible: Collection[int]) -> int | None:
        """Which of the eligible requests is granted; all that request are given too."""
        return min(eligible, key=lambda k: (k <= self._last, k), default=None)

    def accept(self, granted: int) -> None:
        """A request has been granted in this cycle."""
        self._last = granted


class LongestWaiting:
    """The request that has come first; those of the same cycle are in the order of their numbers."""

    def __init__(self):
        self._order: list[int] = []

    def grant(self, requests: Collection[int], eligible: Collection[int]) -> int | None:
        """Which of the eligible requests is granted; all that request are given too. Once in each cycle."""
        self._order = [k for k in self._order if k in requests] + sorted(set(requests) - set(self._order))
        return next((k for k in self._order if k in eligible), None)

    def accept(self, granted: int) -> None:
        """A request has been granted in this cycle: what follows it is a new one."""
        self._order.remove(granted)
