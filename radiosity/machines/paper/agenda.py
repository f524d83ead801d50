"""Agenda: the event queue of a simulation in Python; `EventHeap` serves compiled functions."""

from collections.abc import Callable
from heapq import heappop, heappush
from itertools import count

__all__ = ["Agenda"]


class Agenda:
    """Actions in the order of their times, those of one time in the order of their entry.

    Members
    -------
    now
        The cycle of the action that runs.
    """

    def __init__(self):
        self.now = 0
        self._entries, self._numbers = [], count()

    def at(self, time: int, action: Callable, *arguments: object) -> None:
        """Enter an action.

        Raises
        ------
        ValueError
            The time has passed.
        """
        if time < self.now:
            raise ValueError(f"Time must be at least {self.now}, not {time!r}")
        heappush(self._entries, (time, next(self._numbers), action, arguments))

    def run(self) -> int:
        """Run all actions, those entered meanwhile too: the time of the last one."""
        while self._entries:
            self.now, _, action, arguments = heappop(self._entries)
            action(*arguments)
        return self.now
