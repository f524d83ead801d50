"""Parameters of the network of clusters and patch nodes."""

from dataclasses import dataclass

from golden.base.errors import InputError
from golden.engine.config.checks import check_choice, check_range
from golden.engine.noc.router import ARBITRATIONS
from golden.engine.noc.routing import classes_needed
from golden.engine.noc.topology import TOPOLOGIES, Topology

__all__ = ["MOST_NODES", "Noc"]

MOST_NODES = 64
"""Most nodes of a network."""


@dataclass(frozen=True, kw_only=True)
class Noc:
    """Parameters of the network of clusters and patch nodes.

    Parameters
    ----------
    topology
        ``mesh``, ``torus``, ``ring``, ``illiac`` or ``hypercube``, see `golden.engine.noc.topology`.
    columns, rows
        Nodes side by side, each a cluster or a patch node; 1 to 64 each and at most 64 in all, in a hypercube powers of
        two. A ring visits row after row.
    patch_nodes
        Number of patch nodes, the last of the nodes: they hold a share of the patches and have no cluster; fewer than
        all nodes.
    virtual_channels
        Virtual channels of each input port of a router, for requests and for replies each; 1 to 8. A multiple of 2
        where the links form a cycle in which packets could deadlock (`golden.engine.noc.routing`). Hardware only.
    buffer_flits
        Flits that the queue of a virtual channel holds; 2 to 64. Fewer than the credit round trip in cycles leave links
        idle. Hardware only.
    flit_bits
        Bits of a flit's data; 16 to 256. With the 72 of a vertex a link transfers one vertex per cycle.
    requests
        Patches that a cluster may have outstanding in the network; 1 to 64. A reply occupies a link for five cycles: a
        fifth of the round trip sustains full rate. Hardware only.
    router_cycles
        Cycles in a router, 1 or 2. With 1, arbitration and crossbar share a cycle and the clock is slower. Hardware
        only.
    arbitration
        Arbitration between packets: ``round-robin`` over the queues, or ``age``: the longest waiting. Hardware only.
    networks
        Separation of requests and replies: links of their own, ``physical``, or channels of their own on shared links,
        ``virtual``. Hardware only.
    check
        Check of each flit where it leaves the network: ``none``, ``parity`` or ``crc``.
    """

    topology: str = "mesh"
    columns: int = 4
    rows: int = 2
    patch_nodes: int = 0
    virtual_channels: int = 2
    buffer_flits: int = 8
    flit_bits: int = 72
    requests: int = 4
    router_cycles: int = 2
    arbitration: str = "round-robin"
    networks: str = "physical"
    check: str = "parity"

    def __post_init__(self):
        check_choice("noc", "topology", self.topology, TOPOLOGIES)
        for name, low, high in (("columns", 1, 64), ("rows", 1, 64), ("virtual_channels", 1, 8),
                                ("buffer_flits", 2, 64), ("flit_bits", 16, 256), ("requests", 1, 64),
                                ("router_cycles", 1, 2)):
            check_range("noc", name, getattr(self, name), low, high)
        for name, choices in (("arbitration", ARBITRATIONS), ("networks", ("physical", "virtual")),
                              ("check", ("none", "parity", "crc"))):
            check_choice("noc", name, getattr(self, name), choices)
        if self.nodes > MOST_NODES:
            raise InputError(f"configuration: Columns times rows (noc.columns, noc.rows) must be at most {MOST_NODES}, "
                             f"not {self.columns} x {self.rows}")
        check_range("noc", "patch_nodes", self.patch_nodes, 0, self.nodes - 1)
        classes = classes_needed(self.network())
        if self.virtual_channels % classes:
            raise InputError("configuration: Virtual channels (noc.virtual_channels) must be a multiple of "
                             f"{classes} in a {self.network()}, not {self.virtual_channels!r}")

    def network(self) -> Topology:
        """Nodes, ports and links."""
        return Topology(self.topology, self.columns, self.rows)

    @property
    def nodes(self) -> int:
        """Nodes of the network: a router each, and a cluster or a patch node."""
        return self.columns * self.rows

    @property
    def clusters(self) -> int:
        """Clusters, the first of the nodes."""
        return self.nodes - self.patch_nodes

    @property
    def node_bits(self) -> int:
        """Bits of a node's number."""
        return (self.nodes - 1).bit_length()
