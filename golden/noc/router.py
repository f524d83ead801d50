"""Routers of a network, cycle by cycle: wormhole, credits, a queue per virtual channel."""

from collections import deque
from dataclasses import dataclass

import numpy as np

from golden.errors import InputError
from golden.noc.routing import Routing
from golden.noc.topology import NOWHERE

__all__ = ["ARBITRATIONS", "Flits", "Routers", "Wires"]

ARBITRATIONS = ("round-robin", "age")

_NONE = np.empty(0, dtype=np.int64)
# Of no packet.
_FREE = -1


@dataclass(frozen=True, kw_only=True)
class Flits:
    """All flits of a run, each known by its place here.

    Parameters
    ----------
    destination
        Node of its packet.
    first, last
        Whether it is its packet's first one, its last one; both of a packet of one flit.
    """

    destination: np.ndarray
    first: np.ndarray
    last: np.ndarray


@dataclass(frozen=True, kw_only=True)
class Wires:
    """What is on the wires during a cycle.

    Parameters
    ----------
    queues, flits
        Queues of routers that flits are being sent to, by the number of the output port and the virtual channel
        (``port * channels + channel``), and the flits.
    credits
        Queues that have a place again.
    """

    queues: np.ndarray
    flits: np.ndarray
    credits: np.ndarray


class Routers:
    """All routers of one network, or of several equal ones side by side.

    A router has a queue for each virtual channel of each input port. In each cycle each output port takes one flit of a
    queue that may go: its first flit is to leave there, its packet holds the next channel or finds it free, and the
    next queue has room. Of several the next one after the queue that went last goes, or that whose flit has been its
    first for most cycles, the first of equals. All queues of an input port may go at once.
    A packet holds the channel from its first flit to its last one.

    A flit that is on the wire to a router in cycle t is in its queue in t + 1, where it may be granted; in t + 2 it
    passes the crossbar, in t + 3 it is on the next wire; if routers take one cycle, it passes the crossbar in t + 1 and
    is on the next wire in t + 2. Its place is free again at once: the credit is on the wire back in t + 2.

    Each kind of message has ``routing.virtual_channels`` of its own at each port, those of kind m from m times that on.
    At the node itself packets of a kind come out one after the other, on the kind's first channel.

    Ports are numbered ``node * ports + port``, queues ``port * channels + channel``. Ports without a neighbour (that of
    the node itself always) are served by the caller.

    Parameters
    ----------
    routing
        Where each packet goes on.
    buffer_flits
        Places of a queue.
    messages
        Kinds of messages, which never wait for each other.
    arbitration
        One of `ARBITRATIONS`: in turn, or the longest waiting first.
    router_cycles
        1 or 2.
    copies
        Networks; the nodes of copy c begin at c times their number. Destinations count within a copy.
    alone
        Only this node's router, without a neighbour.

    Raises
    ------
    InputError
        Places or kinds out of range.

    Source: Shen 1993, section 5.2.3.
    """

    def __init__(self, routing: Routing, *, buffer_flits: int, messages: int = 1,
                 arbitration: str = "round-robin", router_cycles: int = 2, copies: int = 1, alone: int | None = None):
        if arbitration not in ARBITRATIONS:
            raise InputError(f"network: Arbitration must be one of {', '.join(ARBITRATIONS)}, not {arbitration!r}")
        for name, value in (("Buffer flits", buffer_flits), ("Messages", messages)):
            if isinstance(value, bool) or not isinstance(value, (int, np.integer)) or value < 1:
                raise InputError(f"network: {name} must be at least 1, not {value!r}")
        if router_cycles not in (1, 2):
            raise InputError(f"network: Router cycles must be 1 or 2, not {router_cycles!r}")
        behind = routing.topology.neighbour
        known = slice(None) if alone is None else slice(alone, alone + 1)
        output, channel = routing.port[known], routing.channel[known]
        behind = behind if alone is None else np.full_like(behind[known], NOWHERE)
        nodes, ports = behind.shape
        per_kind = routing.virtual_channels
        self.channels = messages * per_kind
        self.nodes, self.ports, self.buffer_flits = nodes * copies, ports, buffer_flits
        self._queues_of_node = ports * self.channels
        count = self.nodes * self._queues_of_node

        # The queue that each packet in a queue goes to, in terms of this router's output ports, by destination.
        node, _, came = (axis[..., None] for axis in np.ogrid[:nodes, :ports, :self.channels])
        output, channel = output[:, None, None, :], channel[:, None, None, :]
        channel = channel + came // per_kind * per_kind
        target = (node * ports + output) * self.channels + channel
        target = np.broadcast_to(target, (nodes, ports, *target.shape[2:])).reshape(count // copies, -1)
        self._target = np.concatenate([target + copy * len(target) for copy in range(copies)])

        # From an output port to the input port behind it, and back.
        copy = np.arange(copies)[:, None, None] * nodes
        self._behind = np.where(behind == NOWHERE, NOWHERE,
                                (behind + copy) * ports + np.array(routing.topology.opposite)).reshape(-1)
        self._before = np.full_like(self._behind, NOWHERE)
        linked = np.flatnonzero(self._behind != NOWHERE)
        self._before[self._behind[linked]] = linked

        self._flit, self._goes_to = (np.zeros((count, buffer_flits), dtype=np.int64) for _ in range(2))
        self._head, self._level = (np.zeros(count, dtype=np.int64) for _ in range(2))
        self._credits = np.full(count, buffer_flits, dtype=np.int64)
        self._holder = np.full(count, _FREE, dtype=np.int64)
        self._in_turn = arbitration == "round-robin"
        self._went = np.full(self.nodes * ports, self._queues_of_node - 1, dtype=np.int64)
        # Cycles for which each queue's first flit has been that.
        self._waited = np.zeros(count, dtype=np.int64)
        # What was granted in each of the cycles before, the oldest first.
        self._granted = deque([(_NONE, _NONE)] * router_cycles)
        self._returned = _NONE
        # Flits that were sent, to links and to nodes; cycles in which a port had some to send and could not.
        self.sent = self.stalls = 0
        self._place = np.arange(count) % self._queues_of_node

    @property
    def level(self) -> np.ndarray:
        """Flits in each queue."""
        return self._level

    def wires(self) -> Wires:
        """What the routers put on their wires in the present cycle."""
        queues, flits = self._granted[0]
        return Wires(queues=queues, flits=flits, credits=self._returned)

    def step(self, flits: Flits, *, queues: np.ndarray = _NONE, entering: np.ndarray = _NONE,
             credits: np.ndarray = _NONE) -> None:
        """The end of a cycle.

        Parameters
        ----------
        flits
            All that there are.
        queues, entering
            What the caller has on the wires to the ports that it serves, at most one flit per port.
        credits
            Output queues of those ports for which the caller gives back a place.
        """
        wires = self.wires()
        left, now = self._grant(flits)

        channel, port = wires.credits % self.channels, wires.credits // self.channels
        before = self._before[port]
        linked = before != NOWHERE
        self._credits[before[linked] * self.channels + channel[linked]] += 1
        # The caller may give back several places of a queue at once.
        np.add.at(self._credits, credits, 1)

        channel, port = wires.queues % self.channels, wires.queues // self.channels
        behind = self._behind[port]
        linked = behind != NOWHERE
        queues = np.concatenate([behind[linked] * self.channels + channel[linked], queues])
        entering = np.concatenate([wires.flits[linked], entering])
        place = (self._head[queues] + self._level[queues]) % self.buffer_flits
        self._flit[queues, place] = entering
        self._goes_to[queues, place] = self._target[queues, flits.destination[entering]]
        self._level[queues] += 1

        self._granted.popleft()
        self._granted.append(now)
        self._returned = left

    def _grant(self, flits):
        """The queues that are left, and to which queues which flits go."""
        busy = np.flatnonzero(self._level)
        first, target = self._flit[busy, self._head[busy]], self._goes_to[busy, self._head[busy]]
        may = self._credits[target] > 0
        may &= self._holder[target] == np.where(flits.first[first], _FREE, busy)
        wanted = target // self.channels
        asks, port, place = busy[may], wanted[may], self._place[busy[may]]
        # The smallest goes first.
        if self._in_turn:
            turn = (place - self._went[port] - 1) % self._queues_of_node
        else:
            turn = place - self._queues_of_node * self._waited[asks]
            self._waited[busy] += 1
        order = np.lexsort((turn, port))
        chosen = order[np.flatnonzero(np.diff(port[order], prepend=NOWHERE))]
        ports, queues = port[chosen], asks[chosen]

        self.sent += len(ports)
        self.stalls += np.count_nonzero(np.bincount(wanted)) - len(ports)
        self._went[ports] = place[chosen]
        self._waited[queues] = 0
        gone, targets = first[may][chosen], target[may][chosen]
        self._head[queues] = (self._head[queues] + 1) % self.buffer_flits
        self._level[queues] -= 1
        self._credits[targets] -= 1
        self._holder[targets] = np.where(flits.last[gone], _FREE, queues)
        return queues, (targets, gone)
