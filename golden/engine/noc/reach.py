"""Reach: the destinations of the packets that a queue of a router can hold."""

import numpy as np

from golden.engine.noc.routing import Routing
from golden.engine.noc.topology import LOCAL

__all__ = ["reach"]


def reach(routing: Routing) -> np.ndarray:
    """Whether packets to a destination enter a queue: nodes x ports x virtual channels x destinations bool.

    A node's own packets enter through the port `LOCAL`.
    """
    topology = routing.topology
    nodes = topology.nodes
    enters = np.zeros((nodes, len(topology.ports), routing.virtual_channels, nodes), dtype=bool)
    node, destination = (index.reshape(-1) for index in np.indices((nodes, nodes)))
    port, channel = np.full_like(node, LOCAL), routing.entry[node, destination]
    opposite = np.array(topology.opposite)
    while len(node):
        enters[node, port, channel, destination] = True
        output = routing.port[node, destination]
        on = output != LOCAL
        node, destination, output = node[on], destination[on], output[on]
        channel = routing.channel[node, destination]
        node, port = topology.neighbour[node, output], opposite[output]
    return enters
