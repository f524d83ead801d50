"""Topologies: which processors have a link, and how many links apart any two are."""

import numpy as np

from golden.errors import InputError

__all__ = ["TOPOLOGIES", "grid_shape", "hops", "links"]

TOPOLOGIES = ("mesh", "torus", "ring", "illiac", "hypercube")


def grid_shape(processors: int) -> tuple[int, int]:
    """Columns and rows of a two-dimensional network: powers of two, as square as can be, not higher than wide."""
    bits = int(processors).bit_length() - 1
    return 1 << (bits + 1) // 2, 1 << bits // 2


def links(topology: str, processors: int) -> np.ndarray:
    """Which processors are neighbours.

    Processor ``row * columns + column`` sits at (column, row) of `grid_shape`. *Mesh*: left, right, up and down;
    *torus*: also from border to border; *ring*: the numbers before and after, modulo ``processors``; *illiac*: those
    and the numbers ``columns`` before and after; *hypercube*: the numbers that differ in one bit.

    Parameters
    ----------
    topology
        One of `TOPOLOGIES`.
    processors
        A power of two.

    Returns
    -------
    N x N bool, symmetric.

    Errors
    ------
    InputError
        Another topology, or no power of two.

    Source: Shen 1993, section 6.1.
    """
    if topology not in TOPOLOGIES:
        raise InputError(f"network: Topology must be one of {', '.join(TOPOLOGIES)}, not {topology!r}")
    if isinstance(processors, bool) or not isinstance(processors, (int, np.integer)) or processors < 1 \
            or processors & (processors - 1):
        raise InputError(f"network: Processors must be a power of two, not {processors!r}")
    number = np.arange(processors)
    columns, rows = grid_shape(processors)
    column, row = number % columns, number // columns
    if topology == "mesh":
        distance = np.abs(column[:, None] - column) + np.abs(row[:, None] - row)
        return distance == 1
    neighbours = {
        "torus": [row * columns + (column + 1) % columns, (row + 1) % rows * columns + column],
        "ring": [number + 1],
        "illiac": [number + 1, number + columns],
        "hypercube": [number ^ (1 << bit) for bit in range(int(processors).bit_length() - 1)],
    }[topology]
    linked = np.zeros((processors, processors), dtype=bool)
    for other in neighbours:
        linked[number, other % processors] = True
    linked |= linked.T
    np.fill_diagonal(linked, False)
    return linked


def hops(topology: str, processors: int) -> np.ndarray:
    """Links on a shortest way between any two processors: N x N int64.

    Errors
    ------
    InputError
        As `links`.
    """
    linked = links(topology, processors).astype(np.int64)
    count = np.where(np.eye(processors, dtype=bool), 0, -1)
    reached = np.eye(processors, dtype=bool)
    distance = 0
    while not reached.all():
        distance += 1
        further = (reached @ linked > 0) & ~reached
        count[further] = distance
        reached |= further
    return count
