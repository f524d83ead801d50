"""Exchange steps: who sends which regions to whom, on a mesh of any number of dimensions or from each to all."""

from typing import NamedTuple

import numpy as np

from golden.base.errors import InputError
from radiosity.machines.common.hypercube import ring

__all__ = ["SCHEMES", "ExchangeSteps", "dimensions_of", "mesh_steps", "partners"]

SCHEMES = ("ring", "mesh", "pair", "aapc")


class ExchangeSteps(NamedTuple):
    """K steps of P nodes, each of which sends the pixels of some consecutive regions in each step.

    Parameters
    ----------
    target, source
        K x P int64: the nodes to which a node sends and from which it receives.
    first, last
        K x P int64: the first region that a node sends, and the one after the last.
    region
        P int64: the region that each node has at the end.
    """

    target: np.ndarray
    source: np.ndarray
    first: np.ndarray
    last: np.ndarray
    region: np.ndarray


def dimensions_of(scheme: str, nodes: int) -> tuple[int, ...]:
    """Sides of the mesh: one of all nodes, two as equal as can be, or log2 P of two nodes each.

    Raises
    ------
    InputError
        The scheme is no exchange on a mesh.
    """
    channels = nodes.bit_length() - 1
    meshes = {"ring": (nodes,), "mesh": (1 << (channels + 1) // 2, 1 << channels // 2), "pair": (2,) * channels}
    if scheme not in meshes:
        raise InputError(f"merge: Scheme must be one of {', '.join(SCHEMES)}, not {scheme!r}")
    return tuple(side for side in meshes[scheme] if side > 1)


def mesh_steps(sides: tuple[int, ...]) -> ExchangeSteps:
    """Rings in one dimension after the other, each of which divides the regions that its nodes have left.

    A node at position k of a ring of L nodes sends the (k + i)-th part in step i = 1 .. L - 1 to its left, and receives
    the (k + i + 1)-th from its right, modulo L. Positions are in the order of a Gray code, so each ring has neighbours
    of the hypercube. Rings of two nodes each are the pairwise exchange.

    Source: Kurc 1997, sections 4.4.1 to 4.4.4.
    """
    nodes = int(np.prod(sides, dtype=np.int64))
    node, offset, size = np.arange(nodes), 0, nodes
    region = np.zeros(nodes, dtype=np.int64)
    columns = [[], [], [], []]
    for side in sides:
        around = ring(side)
        position = np.argsort(around)[node >> offset & side - 1]
        size //= side
        beside = [node ^ (around[position] ^ around[(position + move) % side]) << offset for move in (-1, 1)]
        for step in range(1, side):
            first = region + (position + step) % side * size
            for column, values in zip(columns, (*beside, first, first + size), strict=True):
                column.append(values)
        region = region + position * size
        offset += side.bit_length() - 1
    return ExchangeSteps(*(np.array(column, dtype=np.int64).reshape(-1, nodes) for column in columns), region)


def partners(nodes: int, step: int) -> np.ndarray:
    """P int64: whom each node exchanges with in a step 1 .. P - 1 from each to all, by disjoint e-cube routes.

    Source: Kurc 1997, section 4.4.5.
    """
    return np.arange(nodes) ^ step
