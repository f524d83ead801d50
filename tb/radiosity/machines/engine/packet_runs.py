"""Runs of `radiosity.machines.engine.packet_network` with packets that are known before."""

import numpy as np

from golden.engine.noc.network import Packets
from golden.engine.noc.routing import Routing
from radiosity.machines.engine.packet_network import Count, Packet, network_cycle, packet_network, send

__all__ = ["run_packets"]


def run_packets(routing: Routing, given: Packets, **parameters) -> np.ndarray:
    """Send packets when they are made.

    Returns
    -------
    P x 3 int64: cycles in which each packet's first flit entered, and its last one left and was accepted.
    """
    network = packet_network(routing, packets=len(given), **parameters)
    network.packets[:, [Packet.SOURCE, Packet.DESTINATION, Packet.LENGTH, Packet.MADE]] = np.stack(
        [given.source, given.destination, given.length, given.made], axis=1)
    order, sent, cycle = np.argsort(given.made, kind="stable"), 0, 0
    while sent < len(given) or network.counts[Count.UNARRIVED]:
        while sent < len(given) and given.made[order[sent]] <= cycle:
            send(network, order[sent])
            sent += 1
        network_cycle(network, cycle)
        cycle += 1
    return network.packets[:, [Packet.ENTERED, Packet.LEFT, Packet.TAKEN]]
