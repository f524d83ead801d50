"""Merge tree: the collectors of the clusters, and the merge of their intensity messages on the route to the host."""

from typing import NamedTuple

import numpy as np

__all__ = ["MergeTree", "Messages"]


class Messages(NamedTuple):
    """Intensity messages by ascending patch.

    Parameters
    ----------
    patch, sum
        K int64: each patch once, and what its rays add up to.
    time
        K int64: when each message can be taken.
    """

    patch: np.ndarray
    sum: np.ndarray
    time: np.ndarray


class MergeTree:
    """A binary tree of nodes, each of which takes two sorted streams and adds what they have of the same patch.

    A node sends a message a cycle. It sends one when it has the next message of both streams, or their ends: no smaller
    patch can follow.

    Parameters
    ----------
    levels
        Levels of nodes, at least 0.

    Members
    -------
    messages
        Count of the messages that have reached the host.

    Source: Shen & Deprettere, section 1.3.2, where the collector is distributed over clusters; the tree is our choice.
    """

    def __init__(self, *, levels: int):
        # Of each level of nodes, when each of them is free.
        self._free = [[0] * (1 << level) for level in range(levels)]
        self.messages = 0

    def merge(self, streams: list[Messages], ends: list[int]) -> tuple[Messages, int]:
        """Merge the messages of 2^levels clusters: those at the host, and when it knows that there are no more.

        Parameters
        ----------
        streams
            Messages of each cluster.
        ends
            When each cluster has no more messages.
        """
        nodes = [(*map(np.ndarray.tolist, stream), end) for stream, end in zip(streams, ends, strict=True)]
        for level in reversed(self._free):
            for number in range(len(level)):
                nodes[number] = _merged(nodes[2 * number], nodes[2 * number + 1], level[number])
                level[number] = nodes[number][3]
            del nodes[len(level):]
        patch, total, time, end = nodes[0]
        self.messages += len(patch)
        return Messages(*(np.array(value, dtype=np.int64) for value in (patch, total, time))), end


def _merged(left, right, free):
    """Two streams with their ends, by a node that is free from a cycle on."""
    streams, at, out = (left, right), [0, 0], ([], [], [])
    now = free
    while any(at[side] < len(streams[side][0]) for side in (0, 1)):
        heads = [(streams[side][0][at[side]], streams[side][2][at[side]]) if at[side] < len(streams[side][0])
                 else (None, streams[side][3]) for side in (0, 1)]
        patch = min(head for head, _ in heads if head is not None)
        now = max(now, *(time for _, time in heads)) + 1
        total = 0
        for side in (0, 1):
            if heads[side][0] == patch:
                total += streams[side][1][at[side]]
                at[side] += 1
        for values, value in zip(out, (patch, total, now), strict=True):
            values.append(value)
    return *out, max(now, left[3], right[3])
