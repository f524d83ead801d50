"""Hypercube: messages on its links, from one node directly to any other, and the host beside node 0."""

from typing import NamedTuple

import numpy as np

from golden.base.compiled import compiled
from radiosity.machines.common.node_timing import NodeTiming

__all__ = ["MESSAGES", "WORDS", "Hypercube", "hypercube", "ring", "transfer"]

# Columns of what a node has sent.
MESSAGES, WORDS = 0, 1


class Hypercube(NamedTuple):
    """Links and counts, which compiled functions change. Node P is the host.

    Parameters
    ----------
    free
        (P + 1) x (d + 1) int64: when each node's link to its neighbour over each channel is free; channel d of node 0
        leads to the host, and of the host to node 0.
    sent
        (P + 1) x 2 int64: messages and words that each node has sent.
    setup, word
        ns to set a message up, and of a word.
    """

    free: np.ndarray
    sent: np.ndarray
    setup: int
    word: int


def hypercube(nodes: int, timing: NodeTiming) -> Hypercube:
    """Idle links of P nodes, a power of two, and a host."""
    return Hypercube(free=np.zeros((nodes + 1, nodes.bit_length()), dtype=np.int64),
                     sent=np.zeros((nodes + 1, 2), dtype=np.int64), setup=timing.setup, word=timing.word)


def ring(nodes: int) -> np.ndarray:
    """Nodes in an order in which each is a neighbour of the next, and the last one of the first: a Gray code."""
    position = np.arange(nodes)
    return position ^ position >> 1


@compiled
def _reserve(cube, source, target, time, is_held):
    """Walk the channels from source to target in ascending order; find when all links are free, or hold them."""
    host, node = len(cube.free) - 1, source
    channels = cube.free.shape[1] - 1
    start = time
    if node == host:
        if is_held:
            cube.free[host, channels] = time
        start, node = max(start, cube.free[host, channels]), 0
    goal = 0 if target == host else target
    for channel in range(channels):
        if (node ^ goal) >> channel & 1:
            if is_held:
                cube.free[node, channel] = time
            start = max(start, cube.free[node, channel])
            node ^= 1 << channel
    if target == host:
        if is_held:
            cube.free[0, channels] = time
        start = max(start, cube.free[0, channels])
    return start


@compiled
def transfer(cube: Hypercube, time: int, source: int, target: int, words: int) -> int:
    """When a message arrives that has been set up at ``time``.

    It takes all links of its route at once, when they are free, and holds them until its last word. Routers do not
    delay it, and no node between is interrupted.

    Source: Kurc 1997, section 2.3. It does not say what a message does that finds a link taken.
    """
    end = _reserve(cube, source, target, time, False) + words * cube.word
    _reserve(cube, source, target, end, True)
    cube.sent[source, MESSAGES] += 1
    cube.sent[source, WORDS] += words
    return end
