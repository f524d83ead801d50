"""Packet network: `golden.engine.noc.network` for compiled simulators, with packets that are made while it runs.

Each flit enters, leaves and is accepted in the cycle in which `Network` has it. A cycle takes time for the queues and
nodes that have flits alone, so networks of more than a thousand nodes are simulated flit by flit too.
"""

from typing import NamedTuple

import numpy as np

from golden.base.compiled import compiled
from golden.base.errors import InputError, check_int
from golden.engine.noc.router import check_routers
from golden.engine.noc.routing import Routing
from golden.engine.noc.topology import LOCAL, NOWHERE
from radiosity.machines.common.columns import columns

__all__ = ["Count", "Packet", "PacketNetwork", "network_cycle", "packet_network", "send"]

Packet = columns("Packet", "SOURCE DESTINATION LENGTH MADE ENTERED LEFT TAKEN NEXT")
"""What the sender writes; the cycles in which the first flit has entered, and in which the last one has left and has
been accepted; the next packet of the same source."""

Count = columns("Count", "UNARRIVED TAKEN_NOW BUSY RETURNED SENDING SINKING")
"""Packets sent and not yet accepted, packets accepted in this cycle; entries of the lists of a network."""

_Shape = columns("_Shape", "PORTS CHANNELS ENTRIES BY_AGE")
_Route = columns("_Route", "PORT CHANNEL ENTRY")
_Link = columns("_Link", "BEHIND BEFORE")
_Flit = columns("_Flit", "PACKET NUMBER QUEUE")
_Queue = columns("_Queue", "HEAD LEVEL CREDITS HOLDER SINCE POSITION")
_Port = columns("_Port", "LAST_GRANTED GRANTED PRIORITY")
_Node = columns("_Node", "FIRST LAST SENT SINK_HEAD SINK_LEVEL")
_NONE = -1


class PacketNetwork(NamedTuple):
    """Routers, sources and sinks in flat arrays of int64, which compiled functions change.

    Ports and queues are numbered as in `golden.engine.noc.router.Routers`.

    Parameters
    ----------
    shape
        Ports, channels, entries, by age.
    route
        3 x N x N, port, channel and entry of `Routing`.
    linked
        Of each port the input port at the other end, and the output port there.
    flits, queues, busy
        Of each queue its entries (packet, number of the flit, next queue) and state; the queues that are not empty.
    ports, requested
        Of each output port its last grant and the present one; the ports that are requested.
    wires, on_wires, returned
        Flits on the wires, by cycle modulo the cycles of a router and 1; how many; queues whose credits are returned.
    credits
        Of each source those of its queues.
    nodes, sending, sinking, waiting
        Packets of each source and state of its sink; those with packets; flits in each sink.
    packets
        Packets x 8, see `Packet`; a caller may use a row again when its packet has been accepted.
    taken
        Packets accepted in this cycle.
    counts
        See `Count`.
    """

    shape: np.ndarray
    route: np.ndarray
    linked: np.ndarray
    flits: np.ndarray
    queues: np.ndarray
    busy: np.ndarray
    ports: np.ndarray
    requested: np.ndarray
    wires: np.ndarray
    on_wires: np.ndarray
    returned: np.ndarray
    credits: np.ndarray
    nodes: np.ndarray
    sending: np.ndarray
    sinking: np.ndarray
    waiting: np.ndarray
    packets: np.ndarray
    taken: np.ndarray
    counts: np.ndarray


def packet_network(routing: Routing, *, packets: int, buffer_flits: int, arbitration: str = "round-robin",
                   router_cycles: int = 2) -> PacketNetwork:
    """An empty network for one kind of messages.

    Parameters
    ----------
    routing
        Routing tables.
    packets
        Most packets at a time.
    buffer_flits, arbitration, router_cycles
        See `golden.engine.noc.router.Routers`.

    Raises
    ------
    InputError, TypeError
        As `Routers`; the number of packets is below 1, or no int.
    """
    check_routers(buffer_flits=buffer_flits, messages=1, arbitration=arbitration, router_cycles=router_cycles)
    check_int("network: Packets", packets)
    if packets < 1:
        raise InputError(f"network: Packets must be at least 1, not {packets!r}")
    topology = routing.topology
    neighbour = topology.neighbour
    nodes, ports = neighbour.shape
    channels = routing.virtual_channels
    behind = np.where(neighbour == NOWHERE, NOWHERE, neighbour * ports + np.array(topology.opposite)).reshape(-1)
    before = np.full_like(behind, NOWHERE)
    linked = np.flatnonzero(behind != NOWHERE)
    before[behind[linked]] = linked
    count = nodes * ports * channels

    def array(*shape, value=0):
        return np.full(shape, value, dtype=np.int64)

    state = array(count, len(_Queue))
    state[:, _Queue.CREDITS], state[:, _Queue.HOLDER], state[:, _Queue.POSITION] = buffer_flits, _NONE, _NONE
    granted = array(nodes * ports, len(_Port), value=_NONE)
    granted[:, _Port.LAST_GRANTED] = ports * channels - 1
    of_nodes = array(nodes, len(_Node))
    of_nodes[:, _Node.FIRST] = _NONE
    return PacketNetwork(
        shape=np.array([ports, channels, buffer_flits, arbitration == "age"], dtype=np.int64),
        route=np.stack([routing.port, routing.channel, routing.entry]),
        linked=np.stack([behind, before], axis=1), flits=array(count, buffer_flits, 3), queues=state, busy=array(count),
        ports=granted, requested=array(nodes * ports),
        wires=array(router_cycles + 1, nodes * ports, 3), on_wires=array(router_cycles + 1),
        returned=array(2 * nodes * ports), credits=array(nodes, channels, value=buffer_flits),
        nodes=of_nodes, sending=array(nodes), sinking=array(nodes),
        waiting=array(nodes, channels * buffer_flits, 3), packets=array(packets, len(Packet)), taken=array(nodes),
        counts=array(len(Count)))


@compiled
def send(network: PacketNetwork, packet: int) -> None:
    """A source sends a packet from the cycle in its column `MADE` on, after those that it was given before."""
    packets, source = network.packets, network.packets[packet, Packet.SOURCE]
    state = network.nodes[source]
    for column in (Packet.ENTERED, Packet.LEFT, Packet.TAKEN, Packet.NEXT):
        packets[packet, column] = _NONE
    if state[_Node.FIRST] == _NONE:
        state[_Node.FIRST] = packet
        network.sending[network.counts[Count.SENDING]] = source
        network.counts[Count.SENDING] += 1
    else:
        packets[state[_Node.LAST], Packet.NEXT] = packet
    state[_Node.LAST] = packet
    network.counts[Count.UNARRIVED] += 1


@compiled
def network_cycle(network: PacketNetwork, cycle: int) -> None:
    """One cycle; ``taken`` has the packets that their destinations have accepted in it.

    Cycles are called one after the other; those in which no packet is unarrived may be left out.
    """
    # All grants, acceptances and entries follow from the state at the cycle's begin.
    slot, earlier = cycle % len(network.on_wires), network.counts[Count.RETURNED]
    _grant(network, cycle, slot)
    _take(network, cycle)
    _enter(network, cycle)
    _return_credits(network, earlier)
    _arrive(network, cycle, (cycle + 1) % len(network.on_wires))


@compiled
def _grant(network, cycle, slot):
    """Each output port grants one eligible queue: its first flit is on the wires after the cycles of a router."""
    queues, ports = network.queues, network.ports
    channels, of_node = network.shape[_Shape.CHANNELS], network.shape[_Shape.PORTS] * network.shape[_Shape.CHANNELS]
    requested = 0
    for at in range(network.counts[Count.BUSY]):
        queue = network.busy[at]
        head = queues[queue, _Queue.HEAD]
        target = network.flits[queue, head, _Flit.QUEUE]
        holder = _NONE if network.flits[queue, head, _Flit.NUMBER] == 0 else queue
        if queues[target, _Queue.CREDITS] == 0 or queues[target, _Queue.HOLDER] != holder:
            continue
        port = target // channels
        if network.shape[_Shape.BY_AGE]:
            priority = queue % of_node - of_node * (cycle - queues[queue, _Queue.SINCE])
        else:
            priority = (queue % of_node + of_node - ports[port, _Port.LAST_GRANTED] - 1) % of_node
        if ports[port, _Port.GRANTED] == _NONE:
            network.requested[requested] = port
            requested += 1
        elif ports[port, _Port.PRIORITY] < priority:
            continue
        ports[port, _Port.GRANTED], ports[port, _Port.PRIORITY] = queue, priority
    for index in range(requested):
        port = network.requested[index]
        queue = ports[port, _Port.GRANTED]
        ports[port, _Port.GRANTED], ports[port, _Port.LAST_GRANTED] = _NONE, queue % of_node
        _leave(network, queue, cycle, slot)


@compiled
def _leave(network, queue, cycle, slot):
    """The first flit of a queue leaves it."""
    queues, wire = network.queues, network.wires[slot, network.on_wires[slot]]
    first = network.flits[queue, queues[queue, _Queue.HEAD]]
    target = first[_Flit.QUEUE]
    wire[_Flit.PACKET], wire[_Flit.NUMBER], wire[_Flit.QUEUE] = first[_Flit.PACKET], first[_Flit.NUMBER], target
    network.on_wires[slot] += 1
    queues[target, _Queue.CREDITS] -= 1
    last = network.packets[first[_Flit.PACKET], Packet.LENGTH] - 1
    queues[target, _Queue.HOLDER] = _NONE if first[_Flit.NUMBER] == last else queue
    queues[queue, _Queue.HEAD] = (queues[queue, _Queue.HEAD] + 1) % network.shape[_Shape.ENTRIES]
    queues[queue, _Queue.LEVEL] -= 1
    queues[queue, _Queue.SINCE] = cycle + 1
    if queues[queue, _Queue.LEVEL] == 0:
        network.counts[Count.BUSY] -= 1
        moved, position = network.busy[network.counts[Count.BUSY]], queues[queue, _Queue.POSITION]
        network.busy[position] = moved
        queues[moved, _Queue.POSITION] = position
    network.returned[network.counts[Count.RETURNED]] = queue
    network.counts[Count.RETURNED] += 1


@compiled
def _take(network, cycle):
    """Each sink accepts a flit; its credit returns at once."""
    nodes, counts = network.nodes, network.counts
    ports, channels = network.shape[_Shape.PORTS], network.shape[_Shape.CHANNELS]
    counts[Count.TAKEN_NOW], at = 0, 0
    while at < counts[Count.SINKING]:
        node = network.sinking[at]
        flit = network.waiting[node, nodes[node, _Node.SINK_HEAD]]
        packet = flit[_Flit.PACKET]
        network.queues[(node * ports + LOCAL) * channels + flit[_Flit.QUEUE], _Queue.CREDITS] += 1
        if flit[_Flit.NUMBER] == network.packets[packet, Packet.LENGTH] - 1:
            network.packets[packet, Packet.TAKEN] = cycle
            network.taken[counts[Count.TAKEN_NOW]] = packet
            counts[Count.TAKEN_NOW] += 1
            counts[Count.UNARRIVED] -= 1
        nodes[node, _Node.SINK_HEAD] = (nodes[node, _Node.SINK_HEAD] + 1) % network.waiting.shape[1]
        nodes[node, _Node.SINK_LEVEL] -= 1
        if nodes[node, _Node.SINK_LEVEL]:
            at += 1
        else:
            counts[Count.SINKING] -= 1
            network.sinking[at] = network.sinking[counts[Count.SINKING]]


@compiled
def _enter(network, cycle):
    """Each source sends a flit if it has one and a credit."""
    counts, ports, channels = network.counts, network.shape[_Shape.PORTS], network.shape[_Shape.CHANNELS]
    at = 0
    while at < counts[Count.SENDING]:
        node = network.sending[at]
        state = network.nodes[node]
        packet = state[_Node.FIRST]
        given = network.packets[packet]
        channel = network.route[_Route.ENTRY, node, given[Packet.DESTINATION]]
        if given[Packet.MADE] <= cycle and network.credits[node, channel]:
            network.credits[node, channel] -= 1
            if state[_Node.SENT] == 0:
                given[Packet.ENTERED] = cycle
            _put(network, (node * ports + LOCAL) * channels + channel, packet, state[_Node.SENT], cycle)
            state[_Node.SENT] += 1
            if state[_Node.SENT] == given[Packet.LENGTH]:
                state[_Node.FIRST], state[_Node.SENT] = given[Packet.NEXT], 0
        if state[_Node.FIRST] == _NONE:
            counts[Count.SENDING] -= 1
            network.sending[at] = network.sending[counts[Count.SENDING]]
        else:
            at += 1


@compiled
def _return_credits(network, earlier):
    """The credits of the cycle before arrive; those of this one follow in the next."""
    returned, channels, ports = network.returned, network.shape[_Shape.CHANNELS], network.shape[_Shape.PORTS]
    for index in range(earlier):
        port, channel = returned[index] // channels, returned[index] % channels
        before = network.linked[port, _Link.BEFORE]
        if before != NOWHERE:
            network.queues[before * channels + channel, _Queue.CREDITS] += 1
        else:
            network.credits[port // ports, channel] += 1
    now = network.counts[Count.RETURNED] - earlier
    for index in range(now):
        returned[index] = returned[index + earlier]
    network.counts[Count.RETURNED] = now


@compiled
def _arrive(network, cycle, slot):
    """Flits on the wires are in the next queue, or in a sink."""
    channels = network.shape[_Shape.CHANNELS]
    for index in range(network.on_wires[slot]):
        flit = network.wires[slot, index]
        port, channel = flit[_Flit.QUEUE] // channels, flit[_Flit.QUEUE] % channels
        behind = network.linked[port, _Link.BEHIND]
        if behind != NOWHERE:
            _put(network, behind * channels + channel, flit[_Flit.PACKET], flit[_Flit.NUMBER], cycle)
            continue
        node = port // network.shape[_Shape.PORTS]
        state = network.nodes[node]
        entry = network.waiting[node, (state[_Node.SINK_HEAD] + state[_Node.SINK_LEVEL]) % network.waiting.shape[1]]
        entry[_Flit.PACKET], entry[_Flit.NUMBER], entry[_Flit.QUEUE] = flit[_Flit.PACKET], flit[_Flit.NUMBER], channel
        if state[_Node.SINK_LEVEL] == 0:
            network.sinking[network.counts[Count.SINKING]] = node
            network.counts[Count.SINKING] += 1
        state[_Node.SINK_LEVEL] += 1
        if flit[_Flit.NUMBER] == network.packets[flit[_Flit.PACKET], Packet.LENGTH] - 1:
            network.packets[flit[_Flit.PACKET], Packet.LEFT] = cycle
    network.on_wires[slot] = 0


@compiled
def _put(network, queue, packet, number, cycle):
    """A flit is the last one of a queue from the next cycle on."""
    state, ports, channels = network.queues[queue], network.shape[_Shape.PORTS], network.shape[_Shape.CHANNELS]
    node, destination = queue // channels // ports, network.packets[packet, Packet.DESTINATION]
    flit = network.flits[queue, (state[_Queue.HEAD] + state[_Queue.LEVEL]) % network.shape[_Shape.ENTRIES]]
    flit[_Flit.PACKET], flit[_Flit.NUMBER] = packet, number
    flit[_Flit.QUEUE] = ((node * ports + network.route[_Route.PORT, node, destination]) * channels
                    + network.route[_Route.CHANNEL, node, destination])
    if state[_Queue.LEVEL] == 0:
        state[_Queue.SINCE], state[_Queue.POSITION] = cycle + 1, network.counts[Count.BUSY]
        network.busy[network.counts[Count.BUSY]] = queue
        network.counts[Count.BUSY] += 1
    state[_Queue.LEVEL] += 1
