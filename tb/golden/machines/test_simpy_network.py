"""Two descriptions of a network, processes in SimPy and flat arrays, have equal events."""

import numpy as np
import pytest
import simpy

from golden.noc.routing import route
from golden.noc.topology import Topology
from tb.golden.machines.packet_runs import run_packets
from tb.golden.machines.simpy_network import Packet, SimpyNetwork, cycles
from tb.noc.packets import packets


def run_simpy(routing, given, **parameters):
    """Cycles in which each packet's first flit entered, and its last one left and was accepted."""
    env, delivered = simpy.Environment(), []
    network = SimpyNetwork(env, routing, deliver=delivered.append, **parameters)
    sent = [Packet(source=int(source), destination=int(destination), length=int(length), message=int(message))
            for source, destination, length, message in zip(
                given.source, given.destination, given.length, given.message, strict=True)]

    def nodes():
        for packet, made in sorted(zip(sent, given.made, strict=True), key=lambda pair: pair[1]):
            yield env.timeout(max(0, cycles(int(made)) - 1 - env.now))
            network.send(packet)

    env.process(nodes())
    while len(delivered) < len(sent):
        env.step()
    return np.array([(packet.entered, packet.left, packet.taken) for packet in sent])


@pytest.mark.parametrize(("name", "columns", "rows", "channels", "parameters"), [
    ("torus", 4, 4, 2, {"messages": 2, "arbitration": "round-robin", "router_cycles": 2, "buffer_flits": 8}),
    ("mesh", 4, 2, 1, {"messages": 1, "arbitration": "age", "router_cycles": 1, "buffer_flits": 3})])
def test_events_are_equal(name, columns, rows, channels, parameters):
    routing = route(Topology(name, columns, rows), channels)
    given = packets(np.random.default_rng(11), routing.topology, "hotspot", flits=500, load=0.5, longest=5,
                    messages=parameters["messages"])
    assert np.array_equal(run_packets(routing, given, **parameters), run_simpy(routing, given, **parameters))
