"""When items are transferred: stages between an input and an output, each by its latency and its capacity.

Stages follow from what a docstring says of a unit's timing (`tb.lib.timing`), never from the unit. Items pass them one
after the other, so each item's cycles follow from those before it: there is no simulation, a stage only remembers when
items left it.
"""

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from itertools import count, repeat

__all__ = ["Elastic", "Expand", "Gate", "Gather", "Rigid", "Stage", "Trace", "passage"]


@dataclass
class Trace:
    """What sources offered and when, when sinks stalled, and what was transferred; cycles are numbers of one count.

    Members
    -------
    offered
        By input the first cycle of each item's offer.
    stalled
        By output the cycles without ``ready``.
    cycles
        By input and output the cycles of the transfers.
    """

    offered: dict[str, list[int]] = field(default_factory=dict)
    stalled: dict[str, set[int]] = field(default_factory=dict)
    cycles: dict[str, list[int]] = field(default_factory=dict)

    def ready(self, name: str, cycle: int) -> int:
        """The first cycle from one on in which an output's sink is ready."""
        return next(one for one in count(cycle) if one not in self.stalled[name])


class Stage:
    """A part of the path of items."""

    def passes(self, offered: int, following: Callable[[int], int]) -> int:
        """The cycle in which the next item is accepted.

        Parameters
        ----------
        offered
            The first cycle of its offer.
        following
            From the first cycle of an offer to the cycle in which what follows accepts it.
        """
        raise NotImplementedError


class Elastic(Stage):
    """A queue: an item leaves ``latency`` cycles after its acceptance or later, in order, one per cycle.

    Parameters
    ----------
    latency
        In cycles, or of each item; of 0 an item can leave in the cycle of its acceptance.
    capacity
        It accepts while so many are inside when a cycle begins; None: always.
    interval
        Cycles from one that is accepted to the next one, at least.
    """

    def __init__(self, latency: int | Iterable[int], capacity: int | None = None, *, interval: int = 1):
        self._latency = repeat(latency) if isinstance(latency, int) else iter(latency)
        self._capacity, self._interval = capacity, interval
        self._accepted, self._left = None, []

    def passes(self, offered: int, following: Callable[[int], int]) -> int:
        """See `Stage`."""
        left, capacity = self._left, self._capacity
        accepted = offered if self._accepted is None else max(offered, self._accepted + self._interval)
        if capacity is not None and len(left) >= capacity:
            accepted = max(accepted, left[-capacity] + 1)
        self._accepted = accepted
        left.append(following(max(accepted + next(self._latency), left[-1] + 1 if left else 0)))
        return accepted


class Rigid(Stage):
    """A pipeline whose registers all stall while an item at its end waits, and accept in all other cycles.

    Parameters
    ----------
    latency
        In registers, at least 1.
    """

    def __init__(self, latency: int):
        self._latency, self._stalled, self._accepted = latency, set(), -1

    def passes(self, offered: int, following: Callable[[int], int]) -> int:
        """See `Stage`."""
        moves = (cycle for cycle in count(max(offered, self._accepted + 1)) if cycle not in self._stalled)
        accepted = self._accepted = next(moves)
        for _ in range(self._latency - 1):
            offered = next(moves)
        offered = (accepted if self._latency == 1 else offered) + 1
        # What was at the end before has left in the cycle of the last move.
        self._stalled.update(range(offered, following(offered)))
        return accepted


class Expand(Stage):
    """Gives each item some times, one per cycle, the first one in the cycle in which it accepts the item.

    Parameters
    ----------
    counts
        How often, of each item; one that is given 0 times takes a cycle.
    holds
        It accepts the item in the cycle of the last one instead.
    """

    def __init__(self, counts: Iterable[int], *, holds: bool = False):
        self._counts, self._holds, self._last = iter(counts), holds, -1

    def passes(self, offered: int, following: Callable[[int], int]) -> int:
        """See `Stage`."""
        times, begin = next(self._counts), max(offered, self._last + 1)
        if not times:
            self._last = begin
            return begin
        accepted = self._last = following(begin)
        for _ in range(times - 1):
            self._last = following(self._last + 1)
        return self._last if self._holds else accepted


class Gather(Stage):
    """Passes one of some items on, the last one, in its own cycle; the others it only accepts.

    Parameters
    ----------
    counts
        How many items there are for each that passes: always so many, or each time.
    """

    def __init__(self, counts: int | Iterable[int]):
        self._counts, self._left = repeat(counts) if isinstance(counts, int) else iter(counts), 0

    def passes(self, offered: int, following: Callable[[int], int]) -> int:
        """See `Stage`."""
        self._left = (self._left or next(self._counts)) - 1
        return offered if self._left else following(offered)


class Gate(Stage):
    """Passes items in their own cycle, each not before a cycle of its own.

    Parameters
    ----------
    opens
        The first cycle in which each item may pass.
    """

    def __init__(self, opens: Iterable[int]):
        self._opens = iter(opens)

    def passes(self, offered: int, following: Callable[[int], int]) -> int:
        """See `Stage`."""
        return following(max(offered, next(self._opens)))


def passage(stages: Iterable[Stage], offered: Iterable[int], stalled: set[int] = frozenset()
            ) -> tuple[list[int], list[int]]:
    """The cycles in which items are accepted, and in which they leave.

    Parameters
    ----------
    stages
        From the input to the output.
    offered
        The first cycle of each item's offer.
    stalled
        The cycles in which the output is not ready.
    """
    left = []

    def following(cycle):
        cycle = next(ready for ready in count(cycle) if ready not in stalled)
        left.append(cycle)
        return cycle

    for stage in reversed(list(stages)):
        following = _before(stage, following)
    return [following(cycle) for cycle in offered], left


def _before(stage, following):
    return lambda cycle: stage.passes(cycle, following)
