"""Assignment: which node has which patch or scanline, and the numbers by which nodes know these."""

from dataclasses import dataclass

import numpy as np

from golden.base.errors import InputError, check_choice, check_int
from radiosity.machines.common.nodes import check_power_of_two

__all__ = ["ASSIGNMENTS", "Assignment", "assign", "check_nodes", "of_rows", "shares"]

ASSIGNMENTS = ("random", "scattered", "tiled")


@dataclass(frozen=True, kw_only=True, eq=False)
class Assignment:
    """Patches or scanlines in the order of their new numbers: those of node 0, then those of node 1, and so on.

    Parameters
    ----------
    order
        N int64: the patch or scanline of each new number.
    bounds
        P + 1 int64: first new number of each node, and the one after the last; what is beyond has no node.
    """

    order: np.ndarray
    bounds: np.ndarray

    @property
    def nodes(self) -> int:
        """P."""
        return len(self.bounds) - 1

    @property
    def sizes(self) -> np.ndarray:
        """Patches of each node."""
        return np.diff(self.bounds)

    @property
    def number(self) -> np.ndarray:
        """N int64: the new number of each patch or scanline."""
        return np.argsort(self.order)

    def patches(self, node: int) -> np.ndarray:
        """The patches of a node."""
        return self.order[self.bounds[node]:self.bounds[node + 1]]


def check_nodes(nodes: int, patches: int) -> None:
    """Nodes are those of a hypercube, and each has a patch.

    Raises
    ------
    InputError
        They are no power of two up to 1024, or more than the patches.
    """
    check_power_of_two("gather", "Nodes", nodes)
    if nodes > patches:
        raise InputError(f"gather: Nodes must be at most the {patches} patches, not {nodes}", parameter="nodes")


def shares(count: int, nodes: int) -> np.ndarray:
    """``count`` things in equal shares: the first count mod P nodes have one more."""
    return count // nodes + (np.arange(nodes) < count % nodes)


def of_rows(rows: list) -> Assignment:
    """The assignment that gives each node a list of patches."""
    return Assignment(order=np.concatenate([np.asarray(each, dtype=np.int64) for each in rows]),
                      bounds=np.cumsum([0, *map(len, rows)]))


def assign(kind: str, patches: int, nodes: int, *, seed: int = 0) -> Assignment:
    """Assign so many patches before any row is made.

    Neighbours must have neighbouring numbers. ``scattered`` deals patches to the nodes in turn, ``random`` does so
    after a shuffle, and ``tiled`` gives each node neighbours. The source times tiles without a definition; ours are
    shares of the sequence.

    Parameters
    ----------
    kind
        A name of `ASSIGNMENTS`.
    patches, nodes
        N, and P, a power of two.
    seed
        Seed of the shuffle.

    Raises
    ------
    TypeError
        The number of patches is no int.
    InputError
        The kind is none, the nodes are no hypercube, or more than the patches.

    Source: Kurc 1997, section 2.4.1.
    """
    check_choice("gather: Assignment", kind, ASSIGNMENTS)
    check_int("Patches", patches)
    check_nodes(nodes, patches)
    sequence = np.arange(patches)
    if kind == "random":
        sequence = np.random.default_rng(seed).permutation(patches)
    if kind == "tiled":
        return of_rows(np.split(sequence, np.cumsum(shares(patches, nodes))[:-1]))
    return of_rows([sequence[node::nodes] for node in range(nodes)])
