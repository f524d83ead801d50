"""Demand-driven assignment: the host sends patches to nodes that request them, and each row stays where it is made."""

from typing import NamedTuple

import numpy as np

from golden.base.compiled import compiled
from radiosity.machines.common.columns import columns
from radiosity.machines.common.event_heap import event_heap, next_time, pop, push
from radiosity.machines.common.hypercube import Hypercube, transfer

__all__ = ["DemandedRows", "demand_rows"]

_REQUEST, _FULL, _REPLY, _ROW_ENDS = range(4)
# Words of a request and of a patch in a reply: its number, reflectances and emissions.
_REQUEST_WORDS, _PATCH_WORDS = 1, 7
# First patch of a node's request, patches of it, those that it has made.
_Node = columns("_Node", "FIRST COUNT MADE")
# The host's next patch, nodes that wait for the end, when it is idle, whether a memory is full.
_Host = columns("_Host", "NEXT WAITING IDLE IS_FULL")
_NONE = -1


class DemandedRows(NamedTuple):
    """Rows that nodes have made by request.

    Parameters
    ----------
    node
        N int64: the node that has stored each patch's row, or -1.
    ended
        N int64: when it had the row; 0 of rows that are not stored.
    ends
        P int64: when the host's message of the end reaches each node.
    """

    node: np.ndarray
    ended: np.ndarray
    ends: np.ndarray

    @property
    def is_full(self) -> bool:
        """Whether a memory was full before all rows were made."""
        return bool((self.node == _NONE).any())


def demand_rows(times: np.ndarray, sizes: np.ndarray, free: np.ndarray, cube: Hypercube, start: np.ndarray, *,
                granularity: int = 1) -> DemandedRows:
    """Make rows until all are made or a memory is full.

    A node requests ``granularity`` patches when it has made the rows of those before. A node that cannot store a row
    drops it and sends MEMORY_FULL to the host, which then serves no more. When all nodes wait, the host sends each the
    end of the phase. The source has no times of the host; ours sets messages up as a node does, one after the other.

    Parameters
    ----------
    times, sizes
        N int64: ns of each patch's row, and its bytes.
    free
        P int64: bytes for rows of each node.
    cube
        The links; requests and replies share that of the host.
    start
        P int64: when each node begins.
    granularity
        Patches of a request.

    Source: Kurc 1997, section 2.4.2.
    """
    nodes, count = len(free), len(times)
    found = DemandedRows(np.full(count, _NONE, dtype=np.int64), np.zeros(count, dtype=np.int64),
                         np.zeros(nodes, dtype=np.int64))
    _run(event_heap(2 * nodes + 2), found, times, sizes, np.array(free, dtype=np.int64), cube, start, granularity,
         np.zeros((nodes, len(_Node)), dtype=np.int64), np.zeros(len(_Host), dtype=np.int64))
    return found


@compiled
def _request(heap, cube, node, time, kind):
    """The node sets a request up, or that its memory is full, and sends it."""
    host = len(cube.free) - 1
    push(heap, transfer(cube, time + cube.setup, node, host, _REQUEST_WORDS), kind, node)


@compiled
def _reply(heap, cube, host, node, time, words):
    """The host sets a reply up when it is idle, and sends it."""
    host[_Host.IDLE] = max(time, host[_Host.IDLE]) + cube.setup
    push(heap, transfer(cube, host[_Host.IDLE], len(cube.free) - 1, node, words), _REPLY, node)


@compiled
def _run(heap, found, times, sizes, free, cube, start, granularity, state, host):
    """All events."""
    nodes, count = len(free), len(times)
    for node in range(nodes):
        _request(heap, cube, node, start[node], _REQUEST)
    while next_time(heap) != _NONE:
        time, kind, node = pop(heap)
        if kind <= _FULL:
            host[_Host.IS_FULL] |= kind == _FULL
            if host[_Host.IS_FULL] or host[_Host.NEXT] == count:
                state[node, _Node.COUNT] = 0
                host[_Host.WAITING] += 1
                if host[_Host.WAITING] == nodes:
                    for other in range(nodes):
                        _reply(heap, cube, host, other, time, _REQUEST_WORDS)
                continue
            state[node, _Node.FIRST], state[node, _Node.MADE] = host[_Host.NEXT], 0
            state[node, _Node.COUNT] = min(granularity, count - host[_Host.NEXT])
            host[_Host.NEXT] += state[node, _Node.COUNT]
            _reply(heap, cube, host, node, time, _PATCH_WORDS * state[node, _Node.COUNT])
        elif kind == _REPLY:
            if state[node, _Node.COUNT] == 0:
                found.ends[node] = time
            else:
                push(heap, time + times[state[node, _Node.FIRST]], _ROW_ENDS, node)
        else:
            row = state[node, _Node.FIRST] + state[node, _Node.MADE]
            if sizes[row] > free[node]:
                _request(heap, cube, node, time, _FULL)
                continue
            free[node] -= sizes[row]
            found.node[row], found.ended[row] = node, time
            state[node, _Node.MADE] += 1
            if state[node, _Node.MADE] == state[node, _Node.COUNT]:
                _request(heap, cube, node, time, _REQUEST)
            else:
                push(heap, time + times[row + 1], _ROW_ENDS, node)
