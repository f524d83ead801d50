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

__all__ = ["DESTINATION", "ENTERED", "LEFT", "LENGTH", "MADE", "MESSAGE", "SOURCE", "TAKEN", "TAKEN_NOW", "UNARRIVED",
           "PacketNetwork", "network_cycle", "packet_network", "send"]

# Columns of packets: what the sender writes; the cycles in which the first flit has entered, and in which the last one
# has left and has been accepted; the next packet of the same source and message.
SOURCE, DESTINATION, LENGTH, MESSAGE, MADE, ENTERED, LEFT, TAKEN, _NEXT = range(9)
# Of the counts: packets sent and not yet accepted, packets accepted in this cycle.
UNARRIVED, TAKEN_NOW, _BUSY, _RETURNED, _SENDING, _SINKING = range(6)

_PORTS, _CHANNELS, _KIND, _ENTRIES, _MESSAGES, _BY_AGE = range(6)
_PORT, _CHANNEL, _ENTRY = range(3)
_BEHIND, _BEFORE = range(2)
# Of a flit, in a queue and on a wire.
_PACKET, _NUMBER, _QUEUE = range(3)
_HEAD, _LEVEL, _CREDITS, _HOLDER, _SINCE, _POSITION = range(6)
_LAST_GRANTED, _GRANTED, _PRIORITY = range(3)
_FIRST, _LAST, _SENT = range(3)
_LAST_MESSAGE, _QUEUED, _SINK_HEAD, _SINK_LEVEL = range(4)
_NONE = -1


class PacketNetwork(NamedTuple):
    """Routers, sources and sinks in flat arrays of int64, which compiled functions change.

    Ports and queues are numbered as in `golden.engine.noc.router.Routers`.

    Parameters
    ----------
    shape
        Ports, channels, channels of a kind of messages, entries, kinds, by age.
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
    rows, credits
        Of each source and kind its packets; of each source the credits of its queues.
    nodes, sending, sinking, waiting
        State of each source and sink; those with packets; flits in each sink.
    packets
        Packets x 9, see the columns; a caller may use a row again when its packet has been accepted.
    taken
        Packets accepted in this cycle.
    counts
        See the columns.
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
    rows: np.ndarray
    credits: np.ndarray
    nodes: np.ndarray
    sending: np.ndarray
    sinking: np.ndarray
    waiting: np.ndarray
    packets: np.ndarray
    taken: np.ndarray
    counts: np.ndarray


def packet_network(routing: Routing, *, packets: int, buffer_flits: int, messages: int = 1,
                   arbitration: str = "round-robin", router_cycles: int = 2) -> PacketNetwork:
    """An empty network.

    Parameters
    ----------
    routing
        Routing tables.
    packets
        Most packets at a time.
    buffer_flits, messages, arbitration, router_cycles
        See `golden.engine.noc.router.Routers`.

    Raises
    ------
    InputError, TypeError
        As `Routers`; the number of packets is below 1, or no int.
    """
    check_routers(buffer_flits=buffer_flits, messages=messages, arbitration=arbitration, router_cycles=router_cycles)
    check_int("network: Packets", packets)
    if packets < 1:
        raise InputError(f"network: Packets must be at least 1, not {packets!r}")
    topology = routing.topology
    neighbour = topology.neighbour
    nodes, ports = neighbour.shape
    channels = messages * routing.virtual_channels
    behind = np.where(neighbour == NOWHERE, NOWHERE, neighbour * ports + np.array(topology.opposite)).reshape(-1)
    before = np.full_like(behind, NOWHERE)
    linked = np.flatnonzero(behind != NOWHERE)
    before[behind[linked]] = linked
    count = nodes * ports * channels

    def array(*shape, value=0):
        return np.full(shape, value, dtype=np.int64)

    state = array(count, 6)
    state[:, _CREDITS], state[:, _HOLDER], state[:, _POSITION] = buffer_flits, _NONE, _NONE
    granted = array(nodes * ports, 3, value=_NONE)
    granted[:, _LAST_GRANTED] = ports * channels - 1
    rows = array(nodes * messages, 3, value=_NONE)
    rows[:, _SENT] = 0
    of_nodes = array(nodes, 4)
    of_nodes[:, _LAST_MESSAGE] = messages - 1
    return PacketNetwork(
        shape=np.array([ports, channels, routing.virtual_channels, buffer_flits, messages, arbitration == "age"],
                       dtype=np.int64),
        route=np.stack([routing.port, routing.channel, routing.entry]),
        linked=np.stack([behind, before], axis=1), flits=array(count, buffer_flits, 3), queues=state, busy=array(count),
        ports=granted, requested=array(nodes * ports),
        wires=array(router_cycles + 1, nodes * ports, 3), on_wires=array(router_cycles + 1),
        returned=array(2 * nodes * ports), rows=rows, credits=array(nodes, channels, value=buffer_flits),
        nodes=of_nodes, sending=array(nodes), sinking=array(nodes),
        waiting=array(nodes, channels * buffer_flits, 3), packets=array(packets, 9), taken=array(nodes),
        counts=array(6))


@compiled
def send(network: PacketNetwork, packet: int) -> None:
    """A source sends a packet from the cycle in its column `MADE` on, after those that it was given before."""
    packets, rows = network.packets, network.rows
    source = packets[packet, SOURCE]
    row = source * network.shape[_MESSAGES] + packets[packet, MESSAGE]
    packets[packet, _NEXT] = packets[packet, ENTERED] = packets[packet, LEFT] = packets[packet, TAKEN] = _NONE
    if rows[row, _FIRST] == _NONE:
        rows[row, _FIRST] = packet
    else:
        packets[rows[row, _LAST], _NEXT] = packet
    rows[row, _LAST] = packet
    if network.nodes[source, _QUEUED] == 0:
        network.sending[network.counts[_SENDING]] = source
        network.counts[_SENDING] += 1
    network.nodes[source, _QUEUED] += 1
    network.counts[UNARRIVED] += 1


@compiled
def network_cycle(network: PacketNetwork, cycle: int) -> None:
    """One cycle; ``taken`` has the packets that their destinations have accepted in it.

    Cycles are called one after the other; those in which no packet is unarrived may be left out.
    """
    # All grants, acceptances and entries follow from the state at the cycle's begin.
    slot, earlier = cycle % len(network.on_wires), network.counts[_RETURNED]
    _grant(network, cycle, slot)
    _take(network, cycle)
    _enter(network, cycle)
    _return_credits(network, earlier)
    _arrive(network, cycle, (cycle + 1) % len(network.on_wires))


@compiled
def _grant(network, cycle, slot):
    """Each output port grants one eligible queue: its first flit is on the wires after the cycles of a router."""
    queues, ports = network.queues, network.ports
    channels, of_node = network.shape[_CHANNELS], network.shape[_PORTS] * network.shape[_CHANNELS]
    requested = 0
    for at in range(network.counts[_BUSY]):
        queue = network.busy[at]
        head = queues[queue, _HEAD]
        target = network.flits[queue, head, _QUEUE]
        holder = _NONE if network.flits[queue, head, _NUMBER] == 0 else queue
        if queues[target, _CREDITS] == 0 or queues[target, _HOLDER] != holder:
            continue
        port = target // channels
        if network.shape[_BY_AGE]:
            priority = queue % of_node - of_node * (cycle - queues[queue, _SINCE])
        else:
            priority = (queue % of_node + of_node - ports[port, _LAST_GRANTED] - 1) % of_node
        if ports[port, _GRANTED] == _NONE:
            network.requested[requested] = port
            requested += 1
        elif ports[port, _PRIORITY] < priority:
            continue
        ports[port, _GRANTED], ports[port, _PRIORITY] = queue, priority
    for index in range(requested):
        port = network.requested[index]
        queue = ports[port, _GRANTED]
        ports[port, _GRANTED], ports[port, _LAST_GRANTED] = _NONE, queue % of_node
        _leave(network, queue, cycle, slot)


@compiled
def _leave(network, queue, cycle, slot):
    """The first flit of a queue leaves it."""
    queues, wire = network.queues, network.wires[slot, network.on_wires[slot]]
    first = network.flits[queue, queues[queue, _HEAD]]
    target = first[_QUEUE]
    wire[_PACKET], wire[_NUMBER], wire[_QUEUE] = first[_PACKET], first[_NUMBER], target
    network.on_wires[slot] += 1
    queues[target, _CREDITS] -= 1
    last = network.packets[first[_PACKET], LENGTH] - 1
    queues[target, _HOLDER] = _NONE if first[_NUMBER] == last else queue
    queues[queue, _HEAD] = (queues[queue, _HEAD] + 1) % network.shape[_ENTRIES]
    queues[queue, _LEVEL] -= 1
    queues[queue, _SINCE] = cycle + 1
    if queues[queue, _LEVEL] == 0:
        network.counts[_BUSY] -= 1
        moved, position = network.busy[network.counts[_BUSY]], queues[queue, _POSITION]
        network.busy[position] = moved
        queues[moved, _POSITION] = position
    network.returned[network.counts[_RETURNED]] = queue
    network.counts[_RETURNED] += 1


@compiled
def _take(network, cycle):
    """Each sink accepts a flit; its credit returns at once."""
    nodes, counts = network.nodes, network.counts
    ports, channels = network.shape[_PORTS], network.shape[_CHANNELS]
    counts[TAKEN_NOW], at = 0, 0
    while at < counts[_SINKING]:
        node = network.sinking[at]
        flit = network.waiting[node, nodes[node, _SINK_HEAD]]
        packet = flit[_PACKET]
        network.queues[(node * ports + LOCAL) * channels + flit[_QUEUE], _CREDITS] += 1
        if flit[_NUMBER] == network.packets[packet, LENGTH] - 1:
            network.packets[packet, TAKEN] = cycle
            network.taken[counts[TAKEN_NOW]] = packet
            counts[TAKEN_NOW] += 1
            counts[UNARRIVED] -= 1
        nodes[node, _SINK_HEAD] = (nodes[node, _SINK_HEAD] + 1) % network.waiting.shape[1]
        nodes[node, _SINK_LEVEL] -= 1
        if nodes[node, _SINK_LEVEL]:
            at += 1
        else:
            counts[_SINKING] -= 1
            network.sinking[at] = network.sinking[counts[_SINKING]]


@compiled
def _enter(network, cycle):
    """Each source sends a flit of the next kind of messages that has one and a credit."""
    rows, counts, messages = network.rows, network.counts, network.shape[_MESSAGES]
    ports, channels = network.shape[_PORTS], network.shape[_CHANNELS]
    at = 0
    while at < counts[_SENDING]:
        node = network.sending[at]
        state, left = network.nodes[node], False
        for offset in range(1, messages + 1):
            message = (state[_LAST_MESSAGE] + offset) % messages
            row = node * messages + message
            packet = rows[row, _FIRST]
            if packet == _NONE or network.packets[packet, MADE] > cycle:
                continue
            given = network.packets[packet]
            channel = (message * network.shape[_KIND]
                       + network.route[_ENTRY, node, given[DESTINATION]])
            if network.credits[node, channel] == 0:
                continue
            network.credits[node, channel] -= 1
            state[_LAST_MESSAGE] = message
            number = rows[row, _SENT]
            if number == 0:
                given[ENTERED] = cycle
            _put(network, (node * ports + LOCAL) * channels + channel, packet, number, cycle)
            rows[row, _SENT] += 1
            if rows[row, _SENT] == given[LENGTH]:
                rows[row, _FIRST], rows[row, _SENT] = given[_NEXT], 0
                state[_QUEUED] -= 1
                left = state[_QUEUED] == 0
            break
        if left:
            counts[_SENDING] -= 1
            network.sending[at] = network.sending[counts[_SENDING]]
        else:
            at += 1


@compiled
def _return_credits(network, earlier):
    """The credits of the cycle before arrive; those of this one follow in the next."""
    returned, channels, ports = network.returned, network.shape[_CHANNELS], network.shape[_PORTS]
    for index in range(earlier):
        port, channel = returned[index] // channels, returned[index] % channels
        before = network.linked[port, _BEFORE]
        if before != NOWHERE:
            network.queues[before * channels + channel, _CREDITS] += 1
        else:
            network.credits[port // ports, channel] += 1
    now = network.counts[_RETURNED] - earlier
    for index in range(now):
        returned[index] = returned[index + earlier]
    network.counts[_RETURNED] = now


@compiled
def _arrive(network, cycle, slot):
    """Flits on the wires are in the next queue, or in a sink."""
    channels = network.shape[_CHANNELS]
    for index in range(network.on_wires[slot]):
        flit = network.wires[slot, index]
        port, channel = flit[_QUEUE] // channels, flit[_QUEUE] % channels
        behind = network.linked[port, _BEHIND]
        if behind != NOWHERE:
            _put(network, behind * channels + channel, flit[_PACKET], flit[_NUMBER], cycle)
            continue
        node = port // network.shape[_PORTS]
        state = network.nodes[node]
        entry = network.waiting[node, (state[_SINK_HEAD] + state[_SINK_LEVEL]) % network.waiting.shape[1]]
        entry[_PACKET], entry[_NUMBER], entry[_QUEUE] = flit[_PACKET], flit[_NUMBER], channel
        if state[_SINK_LEVEL] == 0:
            network.sinking[network.counts[_SINKING]] = node
            network.counts[_SINKING] += 1
        state[_SINK_LEVEL] += 1
        if flit[_NUMBER] == network.packets[flit[_PACKET], LENGTH] - 1:
            network.packets[flit[_PACKET], LEFT] = cycle
    network.on_wires[slot] = 0


@compiled
def _put(network, queue, packet, number, cycle):
    """A flit is the last one of a queue from the next cycle on."""
    state, channels = network.queues[queue], network.shape[_CHANNELS]
    ports, kind = network.shape[_PORTS], network.shape[_KIND]
    node, destination = queue // channels // ports, network.packets[packet, DESTINATION]
    flit = network.flits[queue, (state[_HEAD] + state[_LEVEL]) % network.shape[_ENTRIES]]
    flit[_PACKET], flit[_NUMBER] = packet, number
    flit[_QUEUE] = ((node * ports + network.route[_PORT, node, destination]) * channels
                    + queue % channels // kind * kind + network.route[_CHANNEL, node, destination])
    if state[_LEVEL] == 0:
        state[_SINCE], state[_POSITION] = cycle + 1, network.counts[_BUSY]
        network.busy[network.counts[_BUSY]] = queue
        network.counts[_BUSY] += 1
    state[_LEVEL] += 1
