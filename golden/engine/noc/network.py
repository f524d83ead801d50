"""A network with its nodes: packets enter at sources and leave at sinks, cycle by cycle."""

from dataclasses import dataclass

import numpy as np

from golden.base.errors import InputError
from golden.engine.noc.router import Flits, Routers
from golden.engine.noc.routing import Routing
from golden.engine.noc.topology import LOCAL

__all__ = ["NEVER", "Arrivals", "Network", "Packets"]

# Cycle of an event that has not occurred.
NEVER = -1


@dataclass(frozen=True, kw_only=True)
class Packets:
    """Packets to send, in any order; a source sends those of one kind in the order of ``made``.

    Parameters
    ----------
    source, destination
        int, nodes.
    length
        int, flits of the packet.
    made
        int, first cycle in which it may be sent.
    message
        int, kind of message.
    """

    source: np.ndarray
    destination: np.ndarray
    length: np.ndarray
    made: np.ndarray
    message: np.ndarray

    def __len__(self) -> int:
        return len(self.source)


@dataclass(frozen=True, kw_only=True)
class Arrivals:
    """Cycles in which each flit was on the wires into its first router and out of its last one; or `NEVER`.

    Parameters
    ----------
    packet
        Packet of each flit; the flits of a packet follow each other.
    entered, entry
        Cycle and virtual channel on the wire into the first router.
    left, channel
        Cycle and virtual channel on the wire out of the last router.
    taken
        Cycle in which the sink accepted the flit, and its credit is on the wire.
    credits
        Credits that first routers return to sources, a row for each: cycle on the wire, node, virtual channel.
    """

    packet: np.ndarray
    entered: np.ndarray
    entry: np.ndarray
    left: np.ndarray
    channel: np.ndarray
    taken: np.ndarray
    credits: np.ndarray


class Network:
    """Routers with a source and a sink at each node.

    A source sends the flits of its packets one after the other, one per cycle. Several kinds of messages have a queue
    each, served in round-robin order, flit by flit. The source holds a credit for each entry of the queues. A sink has
    as many entries, and accepts one flit per cycle in the order of arrival, from the cycle after its arrival.

    Parameters
    ----------
    routing
        Routing tables.
    buffer_flits
        Entries of a queue.
    messages, arbitration, router_cycles, copies
        See `Routers`.
    """

    def __init__(self, routing: Routing, *, buffer_flits: int, messages: int = 1,
                 arbitration: str = "round-robin", router_cycles: int = 2, copies: int = 1):
        self.routers = Routers(routing, buffer_flits=buffer_flits, messages=messages, arbitration=arbitration,
                               router_cycles=router_cycles, copies=copies)
        own = np.arange(messages)[:, None, None] * routing.virtual_channels
        self._entry = own + np.tile(routing.entry, (copies, 1))
        self._messages, self.nodes = messages, self.routers.nodes
        self._buffer_flits = buffer_flits

    def run(self, packets: Packets, *, cycles: int, source_stalls: np.ndarray | None = None,
            sink_stalls: np.ndarray | None = None) -> Arrivals:
        """Send packets through the network, which is empty at first; each network can run once.

        Parameters
        ----------
        cycles
            Most cycles; the run ends earlier when all flits have been accepted.
        source_stalls, sink_stalls
            Cycles x nodes bool, repeated cyclically: the source or the sink stalls.

        Raises
        ------
        InputError
            A packet has an unknown node or kind, or no flits.
        """
        run = _Run(self, packets, self._entry, self._messages)
        for cycle in range(cycles):
            run.cycle(cycle, _row(source_stalls, cycle), _row(sink_stalls, cycle))
            if run.taken_count == len(run.flits.first):
                break
        return run.arrivals()


def _row(stalls, cycle):
    return None if stalls is None else stalls[cycle % len(stalls)]


class _Run:
    """Sources and sinks of a network in a run."""

    def __init__(self, network, packets, entry, messages):
        routers = network.routers
        self._routers, self._messages = routers, messages
        nodes, destinations = network.nodes, entry.shape[2]
        if len(packets) and (packets.length.min() < 1 or packets.source.min() < 0 or packets.destination.min() < 0
                             or packets.source.max() >= nodes or packets.destination.max() >= destinations
                             or packets.message.min() < 0 or packets.message.max() >= messages):
            raise InputError("network: Packets must have a source, a destination and a kind that exist, and a flit")
        # Flits in the order of packets. A row is the queue of a source and a kind: indices into the order of sending.
        self._packet = np.repeat(np.arange(len(packets)), packets.length)
        start = np.cumsum(packets.length) - packets.length
        number = np.arange(len(self._packet)) - start[self._packet]
        self.flits = Flits(destination=packets.destination[self._packet], first=number == 0,
                           last=number == packets.length[self._packet] - 1)
        row = (packets.source * messages + packets.message)[self._packet]
        made = packets.made[self._packet]
        self._order = np.lexsort((np.arange(len(row)), made, row))
        rows = np.arange(nodes * messages)
        self._next = np.searchsorted(row[self._order], rows)
        self._end = np.searchsorted(row[self._order], rows, side="right")
        self._made = np.append(made[self._order], 0)
        self._channel = entry[packets.message, packets.source, packets.destination][self._packet]
        self._row_channel = np.append(self._channel[self._order], 0)

        count = len(self._packet)
        self._entered, self._left, self._left_channel, self._taken = (np.full(count, NEVER) for _ in range(4))
        self.taken_count = 0
        channels, entries = routers.channels, network._buffer_flits
        self._credits, self._returned = np.full((nodes, channels), entries), [np.empty((0, 3), dtype=np.int64)]
        self._last_sent = np.full(nodes, messages - 1)
        self._nodes, self._rows = np.arange(nodes), rows
        self._waiting = np.zeros((nodes, channels * entries), dtype=np.int64)
        self._head, self._level = np.zeros(nodes, dtype=np.int64), np.zeros(nodes, dtype=np.int64)

    def cycle(self, cycle, source_stalls, sink_stalls):
        """One cycle."""
        wires, channels = self._routers.wires(), self._routers.channels
        nodes, entering = self._send(cycle, source_stalls)
        self._entered[entering] = cycle
        takers, taken = self._take(cycle, sink_stalls)
        port, ports = self._routers.ports * self._nodes + LOCAL, self._routers.ports
        self._routers.step(self.flits, queues=port[nodes] * channels + self._channel[entering], entering=entering,
                           credits=port[takers] * channels + self._left_channel[taken])

        local = wires.queues // channels % ports == LOCAL
        node, flits = wires.queues[local] // channels // ports, wires.flits[local]
        self._left[flits], self._left_channel[flits] = cycle, wires.queues[local] % channels
        self._waiting[node, (self._head[node] + self._level[node]) % self._waiting.shape[1]] = flits
        self._level[node] += 1
        back = wires.credits[wires.credits // channels % ports == LOCAL]
        returned = back // channels // ports, back % channels
        np.add.at(self._credits, returned, 1)
        if len(back):
            self._returned.append(np.stack([np.full(len(back), cycle), *returned], axis=1))

    def _send(self, cycle, stalls):
        """The nodes that send, and their flits."""
        index = np.minimum(self._next, len(self._made) - 1)
        ready = (self._next < self._end) & (self._made[index] <= cycle)
        ready &= self._credits[self._rows // self._messages, self._row_channel[index]] > 0
        if stalls is not None:
            ready &= ~np.repeat(stalls, self._messages)
        ready = ready.reshape(-1, self._messages)
        after = (np.arange(self._messages) - self._last_sent[:, None] - 1) % self._messages
        priority = np.where(ready, after, self._messages)
        message = priority.argmin(axis=1)
        nodes = np.flatnonzero(ready.any(axis=1))
        message = message[nodes]
        self._last_sent[nodes] = message
        row = nodes * self._messages + message
        sent = self._order[self._next[row]]
        self._next[row] += 1
        self._credits[nodes, self._channel[sent]] -= 1
        return nodes, sent

    def _take(self, cycle, stalls):
        """The nodes whose sinks accept a flit, and these flits."""
        takes = self._level > 0
        if stalls is not None:
            takes &= ~stalls
        nodes = np.flatnonzero(takes)
        flits = self._waiting[nodes, self._head[nodes]]
        self._head[nodes] = (self._head[nodes] + 1) % self._waiting.shape[1]
        self._level[nodes] -= 1
        self._taken[flits] = cycle
        self.taken_count += len(flits)
        return nodes, flits

    def arrivals(self):
        """The cycles recorded in the run."""
        return Arrivals(packet=self._packet, entered=self._entered, entry=self._channel, left=self._left,
                        channel=self._left_channel, taken=self._taken, credits=np.concatenate(self._returned))
