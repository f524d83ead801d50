"""The compiled network has each flit in the cycle in which `golden.engine.noc.network` has it."""

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.engine.noc.network import Network
from golden.engine.noc.router import ARBITRATIONS
from golden.engine.noc.routing import route
from golden.engine.noc.topology import TOPOLOGIES, Topology
from radiosity.machines.engine.packet_network import packet_network
from tb.golden.engine.noc.networks import networks, starts
from tb.noc.packets import packets
from tb.radiosity.machines.engine.packet_runs import run_packets

pytestmark = pytest.mark.usefixtures("interpreted")


def check(routing, given, **parameters):
    arrivals = Network(routing, **parameters).run(given, cycles=100_000)
    first, last = starts(given), starts(given) + given.length - 1
    expected = np.stack([arrivals.entered[first], arrivals.left[last], arrivals.taken[last]], axis=1)
    assert np.array_equal(run_packets(routing, given, **parameters), expected)


@pytest.mark.parametrize("name", TOPOLOGIES)
def test_packets_arrive_in_the_cycles_of_the_cycle_accurate_model(name):
    for number, routing in networks(name):
        given = packets(np.random.default_rng([7, number]), routing.topology, "uniform", flits=300, load=0.6,
                        longest=6)
        check(routing, given, buffer_flits=(8, 1, 3)[number % 3], arbitration=ARBITRATIONS[number % 2],
              router_cycles=1 + number // 2 % 2)


@pytest.mark.parametrize(("wrong", "error", "message"), [
    ({"packets": 0}, InputError, "Packets must be at least 1, not 0"),
    ({"packets": 1.0}, TypeError, "Packets must be an int, not 1.0"),
    ({"buffer_flits": 0}, InputError, "Buffer flits must be at least 1, not 0")])
def test_parameters_out_of_range_are_refused(wrong, error, message):
    with pytest.raises(error, match=message):
        packet_network(route(Topology("mesh", 2, 1), 1), **{"packets": 1, "buffer_flits": 2, **wrong})
