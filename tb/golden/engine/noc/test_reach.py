import numpy as np
import pytest

from golden.base.errors import InputError
from golden.engine.noc.reach import reach
from golden.engine.noc.routing import route
from golden.engine.noc.topology import LOCAL, TOPOLOGIES, Topology


def walked(routing):
    """Queues that the packets of every pair of nodes enter, one packet after the other, link by link."""
    topology, found = routing.topology, set()
    for source in range(topology.nodes):
        for destination in range(topology.nodes):
            node, port, channel = source, LOCAL, routing.entry[source, destination]
            while True:
                found.add((node, port, int(channel), destination))
                output = int(routing.port[node, destination])
                if output == LOCAL:
                    break
                link, = (one for one in topology.links if one.source == node and one.output == output)
                channel = routing.channel[node, destination]
                node, port = link.target, link.input
            assert node == destination
    return found


@pytest.mark.parametrize(("columns", "rows"), [(1, 1), (2, 1), (4, 1), (2, 2), (4, 2)])
@pytest.mark.parametrize("name", TOPOLOGIES)
def test_queues_are_those_that_packets_enter(name, columns, rows):
    topology = Topology(name, columns, rows)
    for channels in (1, 2):
        try:
            routing = route(topology, channels)
        except InputError:
            continue
        assert {tuple(map(int, index)) for index in np.argwhere(reach(routing))} == walked(routing)
