"""The delay law against the model of the network, one packet at a time."""

import numpy as np
import pytest

from golden.engine.noc.delay import zero_load_latency
from golden.engine.noc.network import Network, Packets
from golden.engine.noc.routing import route
from golden.engine.noc.topology import TOPOLOGIES, Topology


@pytest.mark.parametrize("router_cycles", [1, 2])
@pytest.mark.parametrize("name", TOPOLOGIES)
def test_a_packet_alone_takes_what_the_law_says(name, router_cycles):
    random = np.random.default_rng(5)
    routing = route(Topology(name, 4, 4), 2)
    length = random.integers(1, 17, 8)
    source, destination = random.integers(0, 16, (2, 8))
    # Each when the one before has arrived.
    packets = Packets(source=source, destination=destination, length=length, made=np.arange(8) * 50,
                      message=np.zeros(8, dtype=int))
    arrivals = Network(routing, buffer_flits=8, router_cycles=router_cycles).run(packets, cycles=8 * 50)
    took = arrivals.taken[np.cumsum(length) - 1] - packets.made
    law = zero_load_latency(routing.hops[source, destination], length, router_cycles=router_cycles)
    assert np.array_equal(took, law)


def test_uniform_traffic_of_the_meshes_in_the_literature():
    # Mean distances 2.5 and 5.25; a node's own cycle, which others count, is none here.
    assert zero_load_latency(Topology("mesh", 4, 4).hops.mean()) == 11.5
    assert zero_load_latency(Topology("mesh", 8, 8).hops.mean()) == 19.75
