"""Strings of items, each after a start of a unit of its own."""

from tb.lib.schedules import Schedule

__all__ = ["PAUSE", "started"]

# Cycles around a start, more than a sweep takes.
PAUSE = 64


def started(strings: list[list], times: list[int] | None = None) -> Schedule:
    """A schedule of the inputs ``i_start`` and ``i``; no item is in flight when the next string's start comes.

    Parameters
    ----------
    strings
        The items of each start.
    times
        Cycles that the items of each string take; default: one each.
    """
    starts, items, idle = [], [], 0
    for number, (first, *others) in enumerate(strings):
        starts.append((idle, 0))
        items += [(2 * PAUSE if items else PAUSE, first), *((0, one) for one in others)]
        idle = 2 * PAUSE + (times[number] if times else len(strings[number]))
    return Schedule(items={"i_start": starts, "i": items})
