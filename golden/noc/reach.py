"""What can be in which queue of a router."""

import numpy as np

from golden.noc.routing import Routing
from golden.noc.topology import LOCAL

__all__ = ["reach"]


def reach(routing: Routing) -> np.ndarray:
    """Whether packets to a node come into a queue: nodes x ports x virtual channels x destinations, bool.

    The port `LOCAL` is that through which the node's own packets enter.
    """
    topology = routing.topology
    nodes = topology.nodes
    comes = np.zeros((nodes, len(topology.ports), routing.virtual_channels, nodes), dtype=bool)
    node, destination = (place.reshape(-1) for place in np.indices((nodes, nodes)))
    port, channel = np.full_like(node, LOCAL), routing.entry[node, destination]
    opposite = np.array(topology.opposite)
    while len(node):
        comes[node, port, channel, destination] = True
        output = routing.port[node, destination]
        on = output != LOCAL
        node, destination, output = node[on], destination[on], output[on]
        channel = routing.channel[node, destination]
        node, port = topology.neighbour[node, output], opposite[output]
    return comes
