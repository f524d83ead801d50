"""Mesh links: the loads of the links of a square mesh in an exchange from each node to all others."""

import numpy as np

from golden.base.errors import InputError

__all__ = ["ORDERS", "worst_link_loads"]

ORDERS = ("xor", "shift")


def worst_link_loads(side: int, order: str) -> np.ndarray:
    """P - 1 int64: of each step, the messages on the link that has most; routes go along x first, then along y.

    Parameters
    ----------
    side
        Nodes along each side, a power of two; P is its square.
    order
        ``xor``: node m exchanges with m XOR i in step i, as on a hypercube. ``shift``: each node sends to the one that
        is i / side columns and i mod side rows further, around the mesh.

    Raises
    ------
    InputError
        The order is none, or the side no power of two.

    Source: Kurc 1997, sections 4.4.5 and 4.8; the loads are the digest's.
    """
    if order not in ORDERS:
        raise InputError(f"merge: Order must be one of {', '.join(ORDERS)}, not {order!r}")
    if side < 2 or side & (side - 1):
        raise InputError(f"merge: Side must be a power of two of at least 2, not {side!r}")
    node = np.arange(side * side)
    y, x = np.divmod(node, side)
    loads = []
    for step in range(1, side * side):
        if order == "xor":
            to_y, to_x = np.divmod(node ^ step, side)
        else:
            to_y, to_x = (y + step % side) % side, (x + step // side) % side
        lines = _line_loads(y, x, to_x, side), _line_loads(to_x, y, to_y, side)
        loads.append(max(int(one.max()) for one in lines))
    return np.array(loads, dtype=np.int64)


def _line_loads(line, first, last, side):
    """Messages on each link of each line and direction, between positions ``first`` and ``last`` on it."""
    found = np.zeros((2, side, side + 1), dtype=np.int64)
    low, high, direction = np.minimum(first, last), np.maximum(first, last), (first > last).astype(np.int64)
    np.add.at(found, (direction, line, low), 1)
    np.add.at(found, (direction, line, high), -1)
    return found.cumsum(axis=2)
