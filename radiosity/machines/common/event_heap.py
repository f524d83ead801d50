"""Event heap: the events of a simulation, in the order of their times, those of one time in the order of scheduling."""

from typing import NamedTuple

import numpy as np

from golden.base.compiled import compiled
from golden.base.errors import check_int

__all__ = ["EventHeap", "event_heap", "next_time", "pop", "push"]

# Children of an entry: fewer levels than with two, and neighbours in memory.
ARITY = 4
_TIME, _NUMBER, _KIND, _SUBJECT = range(4)
# Counts of the heap: events that wait, and events ever scheduled.
_WAITING, _SCHEDULED = range(2)


class EventHeap(NamedTuple):
    """A heap in flat arrays, which compiled functions change.

    Parameters
    ----------
    entries
        Capacity x 4 int64: time, sequence number, kind and subject of each event; the first one is the next.
    counts
        2 int64: events that wait, and events ever scheduled.
    """

    entries: np.ndarray
    counts: np.ndarray


def event_heap(capacity: int) -> EventHeap:
    """An empty heap of that many entries.

    Raises
    ------
    TypeError
        The capacity is no int.
    ValueError
        It is below 1.
    """
    check_int("Capacity", capacity, least=1)
    return EventHeap(np.zeros((capacity, 4), dtype=np.int64), np.zeros(2, dtype=np.int64))


@compiled
def _copy(entries, source, target):
    """A row, number by number: a copy of slices takes ten times as long."""
    for column in range(4):
        entries[target, column] = entries[source, column]


@compiled
def push(heap: EventHeap, time: int, kind: int, subject: int) -> None:
    """Schedule an event.

    Raises
    ------
    OverflowError
        The heap is full.
    """
    entries, at = heap.entries, heap.counts[_WAITING]
    if at == len(entries):
        raise OverflowError("Events that wait must be at most the capacity of their heap")
    heap.counts[_WAITING] += 1
    number = heap.counts[_SCHEDULED]
    heap.counts[_SCHEDULED] += 1
    # Later numbers are larger, so an event of the same time is never behind this one.
    while at > 0:
        parent = (at - 1) // ARITY
        if entries[parent, _TIME] <= time:
            break
        _copy(entries, parent, at)
        at = parent
    entries[at, _TIME], entries[at, _NUMBER], entries[at, _KIND], entries[at, _SUBJECT] = time, number, kind, subject


@compiled
def next_time(heap: EventHeap) -> int:
    """Time of the next event; -1 if none waits."""
    return heap.entries[0, _TIME] if heap.counts[_WAITING] else -1


@compiled
def pop(heap: EventHeap) -> tuple[int, int, int]:
    """Remove the next event: its time, kind and subject.

    Raises
    ------
    IndexError
        No event waits.
    """
    entries = heap.entries
    if heap.counts[_WAITING] == 0:
        raise IndexError("Events that wait must be at least 1 when one is taken")
    time, kind, subject = entries[0, _TIME], entries[0, _KIND], entries[0, _SUBJECT]
    heap.counts[_WAITING] -= 1
    end = heap.counts[_WAITING]
    moved_time, moved_number = entries[end, _TIME], entries[end, _NUMBER]
    at = 0
    while True:
        first = ARITY * at + 1
        if first >= end:
            break
        least = first
        for child in range(first + 1, min(first + ARITY, end)):
            if entries[child, _TIME] < entries[least, _TIME] or (
                    entries[child, _TIME] == entries[least, _TIME]
                    and entries[child, _NUMBER] < entries[least, _NUMBER]):
                least = child
        if moved_time < entries[least, _TIME] or (
                moved_time == entries[least, _TIME] and moved_number < entries[least, _NUMBER]):
            break
        _copy(entries, least, at)
        at = least
    _copy(entries, end, at)
    return time, kind, subject
