"""Topologies: nodes, ports, links and distances."""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from golden.base.errors import InputError, check_choice, check_int

__all__ = ["LOCAL", "TOPOLOGIES", "Dimension", "Link", "Topology", "grid_shape"]

TOPOLOGIES = ("mesh", "torus", "ring", "illiac", "hypercube")
# The port of the node itself, at every router.
LOCAL = 0
NOWHERE = -1
EAST_WEST, SOUTH_NORTH = ("east", "west"), ("south", "north")


def grid_shape(nodes: int) -> tuple[int, int]:
    """Columns and rows of a two-dimensional network: as square as can be, not higher than wide."""
    rows = max(height for height in range(1, int(nodes**0.5) + 1) if nodes % height == 0)
    return nodes // rows, rows


@dataclass(frozen=True)
class Link:
    """One direction of a connection: what leaves ``source`` at port ``output`` enters ``target`` at port ``input``."""

    source: int
    output: int
    target: int
    input: int


@dataclass(frozen=True, eq=False)
class Dimension:
    """Lines or rings of nodes along which packets move forward or back.

    Parameters
    ----------
    names
        Names of the ports.
    forward, back
        Ports of the two directions; the same in a hypercube.
    size
        Nodes of a line or ring.
    wraps
        Whether they are rings: a link connects position ``size`` - 1 to 0.
    position
        N int64, 0 to ``size`` - 1.
    ahead
        N int64, the node after each, with the ring closed.
    """

    names: tuple[str, ...]
    forward: int
    back: int
    size: int
    wraps: bool
    position: np.ndarray
    ahead: np.ndarray


@dataclass(frozen=True)
class Topology:
    """Nodes, ports and links of a network.

    Node ``row * columns + column`` is at (column, row). *Mesh*: a link to the nodes left, right, above and below;
    *torus*: also from border to border; *ring*: to the numbers before and after, modulo N; *illiac*: to those and the
    numbers ``columns`` before and after, modulo N; *hypercube*: to the numbers that differ in one bit.

    Links are pairs, one in each direction; a link enters at the port at which the opposite link leaves. A dimension of
    size two has one pair, not two between the same nodes; one of size one has no ports. All routers have the same
    ports; some at a border have no link.

    Parameters
    ----------
    name
        One of `TOPOLOGIES`.
    columns, rows
        At least 1; in a hypercube powers of two.

    Raises
    ------
    InputError
        The topology is unknown, or cannot have this size.
    TypeError
        A size is no int.

    Source: Shen 1993, section 5.2.3, Fig. 5.4.
    """

    name: str
    columns: int
    rows: int

    def __post_init__(self):
        check_choice("network: Topology", self.name, TOPOLOGIES)
        for label, value in (("Columns", self.columns), ("Rows", self.rows)):
            check_int(f"network: {label}", value, least=1)
        if self.name == "hypercube" and self.nodes & (self.nodes - 1):
            raise InputError(f"network: Nodes of a hypercube must be a power of two, not {self.nodes!r}")

    @classmethod
    def of(cls, name: str, nodes: int) -> "Topology":
        """The topology of that many nodes, in the shape `grid_shape`.

        Raises
        ------
        InputError
            As the constructor.
        """
        check_int("network: Nodes", nodes, least=1)
        return cls(name, *grid_shape(nodes))

    def __str__(self) -> str:
        return f"{self.name} {self.columns} x {self.rows}"

    @property
    def nodes(self) -> int:
        """Number of nodes."""
        return self.columns * self.rows

    @cached_property
    def coordinates(self) -> np.ndarray:
        """N x 2 int64, column and row of each node."""
        number = np.arange(self.nodes)
        return np.stack([number % self.columns, number // self.columns], axis=1)

    @cached_property
    def dimensions(self) -> tuple[Dimension, ...]:
        """Dimensions in the order of routing."""
        number, (column, row) = np.arange(self.nodes), self.coordinates.T
        if self.name == "hypercube":
            return tuple(Dimension((f"bit_{bit}",), 1 + bit, 1 + bit, 2, False, number >> bit & 1, number ^ 1 << bit)
                         for bit in range(self.nodes.bit_length() - 1))
        after = (number + 1) % self.nodes
        lines = {
            "ring": [(EAST_WEST, self.nodes, number, after)],
            # The line of a row continues in the next row; with a single column both dimensions would be the same.
            "illiac": [(EAST_WEST, self.nodes, number, after),
                       (SOUTH_NORTH, self.rows if self.columns > 1 else 1, row, (number + self.columns) % self.nodes)],
        }.get(self.name, [(EAST_WEST, self.columns, column, row * self.columns + (column + 1) % self.columns),
                          (SOUTH_NORTH, self.rows, row, (number + self.columns) % self.nodes)])
        lines = [line for line in lines if line[1] > 1]
        return tuple(Dimension(names, 1 + 2 * axis, 2 + 2 * axis, size, self.name != "mesh" and size > 2, *rest)
                     for axis, (names, size, *rest) in enumerate(lines))

    @cached_property
    def ports(self) -> tuple[str, ...]:
        """Names of a router's ports; the first, `LOCAL`, is the node's."""
        return ("local", *(name for line in self.dimensions for name in line.names))

    @cached_property
    def neighbour(self) -> np.ndarray:
        """N x ports int64: the node that each port is linked to; -1 for `LOCAL` and where there is no link."""
        behind = np.full((self.nodes, len(self.ports)), NOWHERE, dtype=np.int64)
        for line in self.dimensions:
            linked = np.arange(self.nodes) if line.wraps else np.flatnonzero(line.position < line.size - 1)
            behind[linked, line.forward] = line.ahead[linked]
            behind[line.ahead[linked], line.back] = linked
        return behind

    @cached_property
    def opposite(self) -> tuple[int, ...]:
        """For each output port the input port at the link's other end."""
        other = [LOCAL] * len(self.ports)
        for line in self.dimensions:
            other[line.forward], other[line.back] = line.back, line.forward
        return tuple(other)

    @cached_property
    def links(self) -> tuple[Link, ...]:
        """All links, by source and output port."""
        return tuple(Link(int(source), int(output), int(self.neighbour[source, output]), self.opposite[output])
                     for source, output in np.argwhere(self.neighbour != NOWHERE))

    @cached_property
    def hops(self) -> np.ndarray:
        """N x N int64, links of a shortest route between any two nodes."""
        linked = np.zeros((self.nodes, self.nodes), dtype=np.int64)
        for link in self.links:
            linked[link.source, link.target] = 1
        reached = np.eye(self.nodes, dtype=bool)
        count = np.zeros((self.nodes, self.nodes), dtype=np.int64)
        while not reached.all():
            count[~reached] += 1
            reached |= reached @ linked > 0
        return count
