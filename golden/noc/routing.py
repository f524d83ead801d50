"""Routing: where a packet goes at each router, on which virtual channel, and why it cannot deadlock."""

from dataclasses import dataclass
from functools import cache, cached_property

import networkx as nx
import numpy as np

from golden.errors import InputError
from golden.noc.topology import LOCAL, NOWHERE, Topology

__all__ = ["Routing", "check_deadlock_free", "classes_needed", "dependency_graph", "displacement", "route"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Routing:
    """What the routers know: two tables, looked up by the packet's destination.

    A packet takes the same links and the same virtual channels as every other one from its source to its destination:
    it cannot overtake one.

    Parameters
    ----------
    topology
        The network.
    virtual_channels
        Of every link.
    port
        N x N int64: at each node, the output port of packets to each destination; `LOCAL` at home.
    channel
        N x N int64: the virtual channel that they take on the link behind that port; 0 at home.
    entry
        N x N int64: the virtual channel on which the node gives its own packets to its router.
    """

    topology: Topology
    virtual_channels: int
    port: np.ndarray
    channel: np.ndarray
    entry: np.ndarray

    def way(self, source: int, destination: int) -> list[tuple[int, int, int]]:
        """The links of a packet: node, output port, virtual channel."""
        way, node = [], source
        while node != destination:
            output = int(self.port[node, destination])
            way.append((node, output, int(self.channel[node, destination])))
            node = int(self.topology.neighbour[node, output])
        return way

    @cached_property
    def hops(self) -> np.ndarray:
        """N x N int64, links of the way between any two nodes.

        Raises
        ------
        InputError
            Packets do not arrive.
        """
        count = np.zeros_like(self.port)
        destination = np.arange(self.topology.nodes)[None, :]
        at = np.broadcast_to(destination.T, self.port.shape)
        for _ in range(self.topology.nodes):
            away = at != destination
            if not away.any():
                return count
            count = count + away
            output = self.port[at, destination]
            behind = self.topology.neighbour[at, output]
            at = np.where(away & (behind != NOWHERE), behind, at)
        source, target = np.argwhere(at != destination)[0]
        raise InputError(f"network: {self.topology}: packets from {source} to {target} do not arrive")


def route(topology: Topology, virtual_channels: int) -> Routing:
    """The routing of a network.

    Packets go along one dimension after the other (X first, then Y; in a hypercube bit 0 first), each the shortest way;
    of two equally long ways around a ring, forward to nodes whose column plus row is even, back to the others. In an
    Illiac network the row's line ends in the next row, so the steps along the two are not independent: of all shortest
    combinations the one with the fewest steps from row to row, those last. All ways are as short as can be.

    Where packets pass from the last node of a ring to the first or back (the dateline), a ring of links could wait for
    itself. There the virtual channels are two classes. A packet that will cross the dateline in this dimension takes
    class 0 until then, class 1 on the link that crosses and after; all others keep one class through the dimension,
    0 if they leave it at an even position, else 1. So no packet of class 1 ever waits for class 0 in its dimension, and
    the links of each class end at the dateline. Class c of C has the channels c V/C to (c + 1) V/C - 1.

    Within a class, the destinations behind a link are put in the order of the port that their packets want at the next
    router, then of their numbers, and cut in as many parts as there are channels, of equal traffic if every node sends
    as much to every other. So a packet waits behind as few as can be that go elsewhere, and all queues are used.

    Parameters
    ----------
    virtual_channels
        Of every link; a multiple of the classes that the network needs (`classes_needed`).

    Raises
    ------
    InputError
        Too few channels, with the cycle of links that would wait for each other; or no multiple.

    Source: Shen 1993, section 5.2.3.2 (mesh); Dally and Seitz 1987 (dateline).
    """
    if isinstance(virtual_channels, bool) or not isinstance(virtual_channels, (int, np.integer)) \
            or virtual_channels < 1:
        raise InputError(f"network: Virtual channels must be a whole number of at least 1, not {virtual_channels!r}")
    classes = classes_needed(topology)
    if virtual_channels == 1:
        classes = 1
    if virtual_channels % classes:
        raise InputError(f"network: Virtual channels of a {topology} must be a multiple of {classes}, "
                         f"not {virtual_channels!r}")
    steps = displacement(topology)
    port = _ports(topology, steps)
    lanes = virtual_channels // classes
    group = _classes(topology, steps, port) if classes == 2 else np.zeros_like(port)
    channel = group * lanes + _lane(topology, port, group, lanes)
    entry = np.stack([_share(np.ones_like(outputs), outputs, virtual_channels) for outputs in port])
    routing = Routing(topology=topology, virtual_channels=virtual_channels, port=port, channel=channel, entry=entry)
    check_deadlock_free(routing)
    return routing


@cache
def classes_needed(topology: Topology) -> int:
    """Classes of virtual channels without which the network's routing could deadlock: 1 or 2."""
    port = _ports(topology, displacement(topology))
    return 1 if nx.is_directed_acyclic_graph(dependency_graph(topology, port, np.zeros_like(port))) else 2


def dependency_graph(topology: Topology, port: np.ndarray, channel: np.ndarray) -> nx.DiGraph:
    """Which channels packets hold while they wait for which.

    A vertex is a virtual channel of a link: node, output port, channel. The local ports are no part of it: what leaves
    the network waits for nothing, and nothing in it waits for what is about to enter.

    Parameters
    ----------
    port, channel
        As in `Routing`.
    """
    graph = nx.DiGraph()
    number = np.arange(topology.nodes)
    source, destination = np.nonzero(number[:, None] != number)
    output = port[source, destination]
    graph.add_nodes_from(_vertices(source, output, channel[source, destination]))
    target = topology.neighbour[source, output]
    on = target != destination
    source, destination, output, target = source[on], destination[on], output[on], target[on]
    graph.add_edges_from(zip(_vertices(source, output, channel[source, destination]),
                             _vertices(target, port[target, destination], channel[target, destination]), strict=True))
    return graph


def check_deadlock_free(routing: Routing) -> None:
    """Refuse a routing with channels that could wait for each other in a circle, or with packets that never arrive.

    Raises
    ------
    InputError
        With the circle.

    Source: Dally and Seitz 1987: without a cycle in the graph of dependencies there is no deadlock.
    """
    topology = routing.topology
    routing.hops  # noqa: B018 - refuses what does not arrive
    graph = dependency_graph(topology, routing.port, routing.channel)
    if nx.is_directed_acyclic_graph(graph):
        return
    circle = [edge[0] for edge in nx.find_cycle(graph)]
    links = " -> ".join(f"{node} {topology.ports[output]} channel {channel}"
                        for node, output, channel in [*circle, circle[0]])
    raise InputError(f"network: {topology} with Virtual channels {routing.virtual_channels} can deadlock: {links}")


def displacement(topology: Topology) -> np.ndarray:
    """Steps along each dimension by the rule of `route`, negative back: sources x destinations x dimensions int64."""
    if topology.name == "illiac" and len(topology.dimensions) == 2:
        return _illiac_displacement(topology)
    steps = np.zeros((topology.nodes, topology.nodes, len(topology.dimensions)), dtype=np.int64)
    for place, line in enumerate(topology.dimensions):
        apart = line.position[None, :] - line.position[:, None]
        steps[..., place] = _shorter(topology, apart, line.size) if line.wraps else apart
    return steps


def _odd(topology):
    """To which nodes packets go back where both ways around are equally long."""
    return topology.coordinates.sum(axis=1) % 2 == 1


def _shorter(topology, apart, size):
    """The shorter way around a ring."""
    forward = apart % size
    back = (2 * forward > size) | (2 * forward == size) & _odd(topology)
    return np.where(back, forward - size, forward)


def _illiac_displacement(topology):
    """All numbers of steps from row to row with the steps along the line that remain; the best by the rule of `route`.

    The best for what remains after a step is the best without that step, so that the ways fit together.
    """
    _, down = topology.dimensions
    number = np.arange(topology.nodes)
    best = None
    for rows in range(-(down.size // 2), down.size // 2 + 1):
        end = down.position[:, None] + rows
        allowed = down.wraps | (end >= 0) & (end < down.size)
        along = _shorter(topology, number[None, :] - number[:, None] - rows * topology.columns, topology.nodes)
        # Total, then from row to row, then the direction; larger than all where there is no way around.
        cost = 4 * topology.nodes * (abs(rows) + abs(along)) + 2 * abs(rows) + (_odd(topology) ^ (rows < 0))
        cost = np.where(allowed, cost, np.iinfo(np.int64).max)
        candidate = np.stack([cost, along, np.full_like(along, rows)])
        best = candidate if best is None else np.where(candidate[0] < best[0], candidate, best)
    return np.moveaxis(best[1:], 0, -1)


def _ports(topology, steps):
    """Along the first dimension with steps left."""
    port = np.full(steps.shape[:2], LOCAL, dtype=np.int64)
    for place in reversed(range(len(topology.dimensions))):
        line, go = topology.dimensions[place], steps[..., place]
        port = np.where(go > 0, line.forward, np.where(go < 0, line.back, port))
    return port


def _classes(topology, steps, port):
    """The class of `route`: N x N."""
    chosen = np.zeros_like(port)
    for place, line in enumerate(topology.dimensions):
        if not line.wraps:
            continue
        here, end = line.position[:, None], line.position[:, None] + steps[..., place]
        for output, border in ((line.forward, line.size - 1), (line.back, 0)):
            taken = port == output
            crosses = taken & ((end < 0) | (end >= line.size))
            after = taken & (here == border)
            for _ in range(line.size):
                source, destination = np.nonzero(after)
                after[topology.neighbour[source, output], destination] = True
                after &= taken
            kept = taken & ~crosses & ~after
            chosen[(after & taken) | (kept & (end % 2 == 1))] = 1
    return chosen


def _lane(topology, port, group, lanes):
    """The channel within the class: N x N."""
    lane, traffic = np.zeros_like(port), _traffic(topology, port)
    for link in topology.links:
        behind = np.flatnonzero(port[link.source] == link.output)
        for number in np.unique(group[link.source, behind]):
            packets = behind[group[link.source, behind] == number]
            lane[link.source, packets] = _share(traffic[link.source, packets], port[link.target, packets], lanes)
    return lane


def _traffic(topology, port):
    """How many nodes' packets pass or leave each node on their way to each destination: N x N."""
    count = np.zeros_like(port)
    at, destination = np.indices(port.shape).reshape(2, -1)
    while len(at):
        np.add.at(count, (at, destination), 1)
        on = at != destination
        at, destination = at[on], destination[on]
        at = topology.neighbour[at, port[at, destination]]
    return count


def _share(traffic, wanted, lanes):
    """Lanes of packets with so much traffic each: equal traffic in each lane, in the order of what they want."""
    order = np.argsort(wanted, kind="stable")
    middle = 2 * np.cumsum(traffic[order]) - traffic[order]
    lane = np.empty_like(wanted)
    lane[order] = middle * lanes // (2 * traffic.sum())
    return lane


def _vertices(*columns):
    return zip(*(column.tolist() for column in columns), strict=True)
