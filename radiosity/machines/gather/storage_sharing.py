"""Storage sharing: every node has all patches until its rows need their memory; then patches circulate."""

from typing import NamedTuple

import numpy as np

from golden.base.compiled import compiled
from radiosity.machines.common.event_heap import event_heap, next_time, pop, push
from radiosity.machines.common.hypercube import Hypercube, transfer

__all__ = ["SharedRows", "make_rows"]

_ROW_ENDS, _FULL_ARRIVES = range(2)
_NONE = -1


class SharedRows(NamedTuple):
    """Rows that nodes made while they had all patches.

    Parameters
    ----------
    stored
        P int64: rows that each node has stored.
    ended
        N int64 in the order of the nodes' numbers: when each of them was stored; 0 of the others.
    ends
        P int64: when each node stopped.
    is_full
        Whether a node sent MEMORY_FULL.
    """

    stored: np.ndarray
    ended: np.ndarray
    ends: np.ndarray
    is_full: bool


class _State(NamedTuple):
    """Of each node: rows stored; whether it knows that a memory is full; free bytes."""

    stored: np.ndarray
    knows: np.ndarray
    free: np.ndarray


def make_rows(times: np.ndarray, sizes: np.ndarray, bounds: np.ndarray, free: np.ndarray, cube: Hypercube,
              start: np.ndarray) -> SharedRows:
    """Make rows until all are made or a memory is full.

    A node that cannot store a row drops it and broadcasts MEMORY_FULL. The others stop after the row that they make.
    The source has no form of the broadcast; ours is a tree over the channels, whose messages are forwarded without
    the nodes' work.

    Parameters
    ----------
    times, sizes
        N int64 in the order of the nodes' numbers: ns of each row, and its bytes.
    bounds
        P + 1 int64: the first row of each node, and N.
    free
        P int64: bytes for rows of each node.
    cube
        The links.
    start
        P int64: when each node begins.

    Source: Kurc 1997, section 2.4.1, Fig. 2.6.
    """
    nodes = len(bounds) - 1
    state = _State(np.zeros(nodes, dtype=np.int64), np.zeros(nodes, dtype=np.bool_), np.array(free, dtype=np.int64))
    ends, ended = np.array(start, dtype=np.int64), np.zeros(len(times), dtype=np.int64)
    _run(event_heap(nodes * (nodes + 1)), state, times, sizes, bounds, cube, ended, ends)
    return SharedRows(stored=state.stored, ended=ended, ends=ends, is_full=bool(state.knows.any()))


@compiled
def _broadcast(heap, cube, source, time):
    """A message of a word to all nodes: in step k those that have it send it over channel k."""
    nodes = len(cube.free) - 1
    has = np.zeros(nodes, dtype=np.int64)
    has[source] = time
    for channel in range(cube.free.shape[1] - 1):
        for offset in range(1 << channel):
            node = source ^ offset
            has[node] += cube.setup
            target = node ^ 1 << channel
            has[target] = transfer(cube, has[node], node, target, 1)
            push(heap, has[target], _FULL_ARRIVES, target)


@compiled
def _run(heap, state, times, sizes, bounds, cube, ended, ends):
    """All events."""
    nodes = len(bounds) - 1
    for node in range(nodes):
        if bounds[node] < bounds[node + 1]:
            push(heap, ends[node] + times[bounds[node]], _ROW_ENDS, node)
    while next_time(heap) != _NONE:
        time, kind, node = pop(heap)
        if kind == _FULL_ARRIVES:
            state.knows[node] = True
            continue
        row = bounds[node] + state.stored[node]
        ends[node] = time
        if sizes[row] > state.free[node]:
            if not state.knows[node]:
                state.knows[node] = True
                _broadcast(heap, cube, node, time)
            continue
        state.free[node] -= sizes[row]
        ended[row] = time
        state.stored[node] += 1
        if not state.knows[node] and row + 1 < bounds[node + 1]:
            push(heap, time + times[row + 1], _ROW_ENDS, node)
