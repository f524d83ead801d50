"""Collectives: a vector for all nodes, and scalars reduced over all nodes, one exchange for each channel."""

import numpy as np

from radiosity.machines.common.node_programs import Program

__all__ = ["concatenation", "reduction"]


def _exchanges(words):
    """Steps in which each node exchanges words with its neighbour over channel 0, 1 and so on: from d x P int64."""
    channels, nodes = words.shape
    partner = np.arange(nodes) ^ (1 << np.arange(channels))[:, None]
    return Program(np.zeros_like(words), partner, partner, words)


def concatenation(sizes: np.ndarray, overlaps: np.ndarray | None = None) -> Program:
    """Every node gets the slices of all: the slices that two neighbours hold double with each exchange.

    Parameters
    ----------
    sizes
        P int64: words of each node's slice.
    overlaps
        D x P int64: words that the slices of both neighbours have in common when they exchange them over each channel.
        Default: none.

    Source: Kurc 1997, section 2.5.1, Eq. 2.14.
    """
    words, held = [], np.asarray(sizes, dtype=np.int64)
    for channel in range(len(held).bit_length() - 1):
        words.append(held)
        held = held + held[np.arange(len(held)) ^ 1 << channel] - (0 if overlaps is None else overlaps[channel])
    return _exchanges(np.array(words, dtype=np.int64).reshape(-1, len(held)))


def reduction(nodes: int, words: int) -> Program:
    """Every node gets so many scalars, each added or maximised over all nodes; one message has them all.

    The combination of two scalars takes no time, as in Eqs. 2.15 and 2.16.

    Source: Kurc 1997, section 2.5.1.
    """
    return _exchanges(np.full((nodes.bit_length() - 1, nodes), words, dtype=np.int64))
