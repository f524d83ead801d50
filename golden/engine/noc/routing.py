"""Routing: output port and virtual channel of a packet at each router, and the proof of deadlock freedom."""

from dataclasses import dataclass
from functools import cache, cached_property
from graphlib import CycleError, TopologicalSorter

import numpy as np

from golden.base.errors import InputError, check_int
from golden.engine.noc.topology import LOCAL, NOWHERE, Topology

__all__ = ["Routing", "check_deadlock_free", "classes_needed", "dependency_graph", "displacement", "route"]


@dataclass(frozen=True, kw_only=True, eq=False)
class Routing:
    """The tables of the routers, indexed by the packet's destination.

    All packets from a source to a destination use the same links and virtual channels, so none overtakes another.

    Parameters
    ----------
    topology
        The network.
    virtual_channels
        Virtual channels of each link.
    port
        N x N int64: at each node, the output port of packets to each destination; `LOCAL` at the destination.
    channel
        N x N int64: the virtual channel of these packets on that port's link; 0 at the destination.
    entry
        N x N int64: the virtual channel on which a node sends its own packets to its router.
    """

    topology: Topology
    virtual_channels: int
    port: np.ndarray
    channel: np.ndarray
    entry: np.ndarray

    def path(self, source: int, destination: int) -> list[tuple[int, int, int]]:
        """The links of a packet: node, output port, virtual channel."""
        path, node = [], source
        while node != destination:
            output = int(self.port[node, destination])
            path.append((node, output, int(self.channel[node, destination])))
            node = int(self.topology.neighbour[node, output])
        return path

    @cached_property
    def hops(self) -> np.ndarray:
        """N x N int64, links of the route between any two nodes.

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

    Dimension-order routing: X first, then Y; in a hypercube bit 0 first. Routes are shortest. Of the two directions
    around a ring that are equally long, packets go forward to nodes whose column plus row is even and back to all
    others. In an Illiac network a row's line ends in the next row, so the steps along the two are not independent: of
    all shortest combinations it uses the one with the fewest steps from row to row, and takes those last.

    The links of a ring could deadlock. There the virtual channels form two classes, and the link between the last node
    and the first is the dateline. A packet that will cross the dateline in this dimension uses class 0 before it, and
    class 1 on it and after. All others keep one class through the dimension: 0 if they leave it at an even position,
    else 1. So no packet of class 1 waits for class 0 in its dimension, and the links of each class end at the dateline.
    Class c of C has the channels c V/C to (c + 1) V/C - 1.

    Within a class, the destinations beyond a link are sorted by their output port at the next router, then by number,
    and divided among the channels into parts of equal traffic under uniform load. So few packets wait behind others for
    another port, and all queues are used.

    Parameters
    ----------
    virtual_channels
        Virtual channels of each link; a multiple of the classes that the network needs (`classes_needed`).

    Raises
    ------
    InputError
        Too few channels (the message has the cycle of links), or no multiple of the classes.
    TypeError
        ``virtual_channels`` is no int.

    Source: Shen 1993, section 5.2.3.2 (mesh); Dally and Seitz 1987 (dateline).
    """
    check_int("network: Virtual channels", virtual_channels, least=1)
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
    return 2 if _cycle(dependency_graph(topology, port, np.zeros_like(port))) else 1


def dependency_graph(topology: Topology, port: np.ndarray, channel: np.ndarray) -> dict[tuple, set[tuple]]:
    """Channel dependency graph: to each channel those that packets hold when they request it.

    A vertex is a virtual channel of a link: node, output port, channel. Local ports are not part of it: a packet that
    leaves the network waits for no channel, and no packet in it waits for one that enters.

    Parameters
    ----------
    port, channel
        As in `Routing`.
    """
    number = np.arange(topology.nodes)
    source, destination = np.nonzero(number[:, None] != number)
    output = port[source, destination]
    graph = {vertex: set() for vertex in _vertices(source, output, channel[source, destination])}
    target = topology.neighbour[source, output]
    on = target != destination
    source, destination, output, target = source[on], destination[on], output[on], target[on]
    for held, requested in zip(_vertices(source, output, channel[source, destination]),
                               _vertices(target, port[target, destination], channel[target, destination]),
                               strict=True):
        graph[requested].add(held)
    return graph


def check_deadlock_free(routing: Routing) -> None:
    """The routing delivers every packet and has no cycle of channel dependencies.

    Raises
    ------
    InputError
        There is a cycle, which the message shows, or packets do not arrive.

    Source: Dally and Seitz 1987: without a cycle in the graph of dependencies there is no deadlock.
    """
    topology = routing.topology
    routing.hops  # noqa: B018 - refuses what does not arrive
    cycle = _cycle(dependency_graph(topology, routing.port, routing.channel))
    if not cycle:
        return
    links = " -> ".join(f"{node} {topology.ports[output]} channel {channel}"
                        for node, output, channel in [*cycle, cycle[0]])
    raise InputError(f"network: {topology} with Virtual channels {routing.virtual_channels} can deadlock: {links}")


def displacement(topology: Topology) -> np.ndarray:
    """Steps along each dimension by the rule of `route`, negative back: sources x destinations x dimensions int64."""
    if topology.name == "illiac" and len(topology.dimensions) == 2:
        return _illiac_displacement(topology)
    steps = np.zeros((topology.nodes, topology.nodes, len(topology.dimensions)), dtype=np.int64)
    for axis, line in enumerate(topology.dimensions):
        apart = line.position[None, :] - line.position[:, None]
        steps[..., axis] = _shorter(topology, apart, line.size) if line.wraps else apart
    return steps


def _odd(topology):
    """The nodes to which packets go back where both directions around a ring are equally long: N bool."""
    return topology.coordinates.sum(axis=1) % 2 == 1


def _shorter(topology, apart, size):
    """Signed steps of the shorter route around a ring."""
    forward = apart % size
    back = (2 * forward > size) | (2 * forward == size) & _odd(topology)
    return np.where(back, forward - size, forward)


def _illiac_displacement(topology):
    """The best combination, by the rule of `route`, of steps from row to row and of the remaining steps along the line.

    After a step the rest of a best combination is best for the rest, so the routes are consistent.
    """
    _, down = topology.dimensions
    number = np.arange(topology.nodes)
    best = None
    for rows in range(-(down.size // 2), down.size // 2 + 1):
        end = down.position[:, None] + rows
        allowed = down.wraps | (end >= 0) & (end < down.size)
        along = _shorter(topology, number[None, :] - number[:, None] - rows * topology.columns, topology.nodes)
        # Total steps, then steps from row to row, then the direction; the largest number where there is no route.
        cost = 4 * topology.nodes * (abs(rows) + abs(along)) + 2 * abs(rows) + (_odd(topology) ^ (rows < 0))
        cost = np.where(allowed, cost, np.iinfo(np.int64).max)
        candidate = np.stack([cost, along, np.full_like(along, rows)])
        best = candidate if best is None else np.where(candidate[0] < best[0], candidate, best)
    return np.moveaxis(best[1:], 0, -1)


def _ports(topology, steps):
    """Output port along the first dimension with steps left."""
    port = np.full(steps.shape[:2], LOCAL, dtype=np.int64)
    for axis in reversed(range(len(topology.dimensions))):
        line, go = topology.dimensions[axis], steps[..., axis]
        port = np.where(go > 0, line.forward, np.where(go < 0, line.back, port))
    return port


def _classes(topology, steps, port):
    """The class of `route`: N x N."""
    chosen = np.zeros_like(port)
    for axis, line in enumerate(topology.dimensions):
        if not line.wraps:
            continue
        here, end = line.position[:, None], line.position[:, None] + steps[..., axis]
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
    """Number of nodes whose packets to each destination pass or leave each node: N x N."""
    count = np.zeros_like(port)
    at, destination = np.indices(port.shape).reshape(2, -1)
    while len(at):
        np.add.at(count, (at, destination), 1)
        on = at != destination
        at, destination = at[on], destination[on]
        at = topology.neighbour[at, port[at, destination]]
    return count


def _share(traffic, requested, lanes):
    """Lanes of packets with the traffic given: equal traffic in each lane, in the order of the requested ports."""
    order = np.argsort(requested, kind="stable")
    middle = 2 * np.cumsum(traffic[order]) - traffic[order]
    lane = np.empty_like(requested)
    lane[order] = middle * lanes // (2 * traffic.sum())
    return lane


def _cycle(graph):
    """The vertices of a cycle, from its least one on; none if there is no cycle."""
    try:
        TopologicalSorter(graph).prepare()
    except CycleError as error:
        found = error.args[1][1:]
        first = found.index(min(found))
        return found[first:] + found[:first]
    return []


def _vertices(*columns):
    return zip(*(column.tolist() for column in columns), strict=True)
