"""The network in SimPy: a process for each output port, source and sink, and for each flit and credit on a wire.

It restates the rules of `golden.noc.router` without their arrays, as a reference of `golden.machines.packet_network`.
"""

from collections import deque
from dataclasses import dataclass, field

import simpy

from golden.noc.routing import Routing
from golden.noc.topology import LOCAL, NOWHERE

__all__ = ["Packet", "SimpyNetwork", "cycles"]

# A cycle has two instants: decisions by the state at its begin, and what changes it.
INSTANTS = 2


def cycles(number: int) -> int:
    """Time of the first instant of a cycle, and the duration of so many cycles."""
    return INSTANTS * number


@dataclass(kw_only=True, eq=False)
class Packet:
    """A packet, and the cycles of its events."""

    source: int
    destination: int
    length: int
    message: int
    entered: int = -1
    left: int = -1
    taken: int = -1


@dataclass(kw_only=True, eq=False)
class _Queue:
    """Flits (packet, number) of an input's channel, and the cycle in which the first one may leave."""

    index: int
    flits: deque = field(default_factory=deque)
    since: int = 0


@dataclass(kw_only=True, eq=False)
class _Channel:
    """An output's channel: free entries behind it, and the queue whose packet holds it."""

    credits: int
    holder: _Queue | None = None


class SimpyNetwork:
    """Routers with a source and a sink at each node.

    Parameters
    ----------
    env
        SimPy's environment; its time counts the instants of cycles.
    routing, buffer_flits, messages, arbitration, router_cycles
        See `golden.noc.router.Routers`.
    deliver
        Called with each packet at the end of the cycle in which its destination has accepted it.
    """

    def __init__(self, env: simpy.Environment, routing: Routing, *, buffer_flits: int, messages: int,
                 arbitration: str, router_cycles: int, deliver):
        self._env, self._routing, self._router_cycles, self._deliver = env, routing, router_cycles, deliver
        self._by_age, self._kind = arbitration == "age", routing.virtual_channels
        topology, channels = routing.topology, messages * routing.virtual_channels
        ports = len(topology.ports)
        self._queues = {(node, port, channel): _Queue(index=port * channels + channel)
                        for node in range(topology.nodes) for port in range(ports) for channel in range(channels)}
        self._outputs = {key: _Channel(credits=buffer_flits) for key in self._queues}
        self._entries = {(node, channel): buffer_flits for node in range(topology.nodes) for channel in range(channels)}
        self._given = {(node, message): deque() for node in range(topology.nodes) for message in range(messages)}
        self._sinks = {node: deque() for node in range(topology.nodes)}
        self._awake = {}
        for node in range(topology.nodes):
            for port in range(ports):
                if port == LOCAL or topology.neighbour[node, port] != NOWHERE:
                    env.process(self._port(node, port))
            env.process(self._source(node, messages))
            env.process(self._sink(node))

    @property
    def cycle(self) -> int:
        """The present cycle."""
        return self._env.now // INSTANTS

    def send(self, packet: Packet) -> None:
        """A source sends a packet after those that it was given before, from this cycle's first instant on."""
        self._given[packet.source, packet.message].append((packet, 0))
        self._wake("source", packet.source)

    def _sleep(self, *key):
        """Until the next cycle in which there is something to do."""
        if key not in self._awake or self._awake[key].triggered:
            self._awake[key] = self._env.event()
        yield self._awake[key]
        yield self._env.timeout(-self._env.now % INSTANTS)

    def _wake(self, *key):
        event = self._awake.get(key)
        if event is not None and not event.triggered:
            event.succeed()

    def _after(self, delay, change):
        """Change the state later."""
        def wait():
            yield self._env.timeout(delay)
            change()
        self._env.process(wait())

    def _port(self, node, port):
        """An output port grants one eligible queue in each cycle."""
        queues = {key: queue for key, queue in self._queues.items() if key[0] == node}
        count = len(queues)
        last = count - 1
        while True:
            requests = {key: queue for key, queue in queues.items() if queue.flits and self._next(key)[0] == port}
            if not requests:
                yield from self._sleep("port", node)
                continue
            eligible = []
            for key, queue in requests.items():
                channel = self._outputs[node, port, self._next(key)[1]]
                number = queue.flits[0][1]
                if queue.since <= self.cycle and channel.credits and channel.holder is (queue if number else None):
                    waited = (self.cycle - queue.since) * count if self._by_age else 0
                    order = queue.index if self._by_age else (queue.index - last - 1) % count
                    eligible.append((order - waited, key))
            if eligible:
                key = min(eligible)[1]
                last = queues[key].index
                self._leave(key, port)
            yield self._env.timeout(cycles(1))

    def _next(self, key):
        """Output port and channel of a queue's first packet."""
        node, _, channel = key
        destination = self._queues[key].flits[0][0].destination
        kind = channel // self._kind * self._kind
        return int(self._routing.port[node, destination]), kind + int(self._routing.channel[node, destination])

    def _leave(self, key, port):
        node, came, came_channel = key
        queue, (_, channel) = self._queues[key], self._next(key)
        packet, number = queue.flits.popleft()
        queue.since = self.cycle + 1
        output = self._outputs[node, port, channel]
        output.credits -= 1
        output.holder = None if number == packet.length - 1 else queue
        self._after(cycles(self._router_cycles) + 1, lambda: self._arrive(node, port, channel, packet, number))
        # The new first flit requests its port from the next cycle on.
        self._after(1, lambda: self._wake_ports(node))
        self._after(cycles(1) + 1, lambda: self._return(node, came, came_channel))

    def _return(self, node, port, channel):
        """A credit arrives at the other end of an input's link."""
        if port == LOCAL:
            self._entries[node, channel] += 1
        else:
            topology = self._routing.topology
            self._outputs[int(topology.neighbour[node, port]), topology.opposite[port], channel].credits += 1

    def _arrive(self, node, port, channel, packet, number):
        topology = self._routing.topology
        if port != LOCAL:
            self._put(int(topology.neighbour[node, port]), topology.opposite[port], channel, packet, number)
            return
        if number == packet.length - 1:
            packet.left = self.cycle
        self._sinks[node].append((packet, number, channel))
        self._wake("sink", node)

    def _put(self, node, port, channel, packet, number):
        queue = self._queues[node, port, channel]
        if not queue.flits:
            queue.since = self.cycle + 1
        queue.flits.append((packet, number))
        self._wake_ports(node)

    def _wake_ports(self, node):
        self._wake("port", node)

    def _source(self, node, messages):
        """Flits of the kinds of messages in turn."""
        last = messages - 1
        while True:
            if not any(self._given[node, message] for message in range(messages)):
                yield from self._sleep("source", node)
            for offset in range(1, messages + 1):
                message = (last + offset) % messages
                given = self._given[node, message]
                if not given:
                    continue
                packet, number = given[0]
                channel = message * self._kind + int(self._routing.entry[node, packet.destination])
                if self._entries[node, channel]:
                    self._entries[node, channel] -= 1
                    last = message
                    given.popleft()
                    if number == 0:
                        packet.entered = self.cycle
                    if number + 1 < packet.length:
                        given.appendleft((packet, number + 1))
                    self._after(1, lambda channel=channel, packet=packet, number=number: self._put(
                        node, LOCAL, channel, packet, number))
                    break
            yield self._env.timeout(cycles(1))

    def _sink(self, node):
        """A flit in each cycle, from the one after its arrival on."""
        while True:
            if not self._sinks[node]:
                yield from self._sleep("sink", node)
            packet, number, channel = self._sinks[node].popleft()
            output = self._outputs[node, LOCAL, channel]

            def accept(output=output, packet=packet, number=number):
                output.credits += 1
                if number == packet.length - 1:
                    self._deliver(packet)

            if number == packet.length - 1:
                packet.taken = self.cycle
            self._after(1, accept)
            yield self._env.timeout(cycles(1))
