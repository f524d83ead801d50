"""Routers of a network, cycle by cycle: wormhole, credits, a queue per virtual channel."""

from collections import deque
from dataclasses import dataclass

import numpy as np

from golden.base.errors import InputError, check_choice, check_int
from golden.engine.noc.routing import Routing
from golden.engine.noc.topology import NOWHERE

__all__ = ["ARBITRATIONS", "Flits", "Routers", "Wires", "check_routers"]

ARBITRATIONS = ("round-robin", "age")

_NONE = np.empty(0, dtype=np.int64)
# A channel that no packet holds.
_FREE = -1


def check_routers(*, buffer_flits: int, messages: int, arbitration: str, router_cycles: int) -> None:
    """The parameters are those of a router, see `Routers`.

    Raises
    ------
    InputError
        Arbitration or router cycles are unknown, or entries or kinds out of range.
    TypeError
        Entries or kinds are no int.
    """
    check_choice("network: Arbitration", arbitration, ARBITRATIONS)
    for name, value in (("Buffer flits", buffer_flits), ("Messages", messages)):
        check_int(f"network: {name}", value, least=1)
    if router_cycles not in (1, 2):
        raise InputError(f"network: Router cycles must be 1 or 2, not {router_cycles!r}")


@dataclass(frozen=True, kw_only=True)
class Flits:
    """All flits of a run, each identified by its index.

    Parameters
    ----------
    destination
        N int, destination of its packet.
    first, last
        N bool, whether it is the first and the last flit of its packet; both in a packet of one flit.
    """

    destination: np.ndarray
    first: np.ndarray
    last: np.ndarray


@dataclass(frozen=True, kw_only=True)
class Wires:
    """Flits and credits on the wires during a cycle.

    Parameters
    ----------
    queues, flits
        Destination queues of the flits on the wires, by number of the output port and the virtual channel
        (``port * channels + channel``), and the flits.
    credits
        Queues whose credits are returned.
    """

    queues: np.ndarray
    flits: np.ndarray
    credits: np.ndarray


class Routers:
    """All routers of one network, or of several equal ones side by side.

    A router has a queue for each virtual channel of each input port. In each cycle each output port grants one eligible
    queue. A queue is eligible for a port if its first flit leaves there, the flit's packet holds the next channel or
    finds it free, and there is a credit for the next queue. Arbitration is round-robin, or by age: the queue whose flit
    has been its first for most cycles, the first of equals. All queues of an input port may be granted in one cycle. A
    packet holds its channel from its first flit to its last.

    A flit that is on the wire to a router in cycle t is in its queue in t + 1, where it may be granted; in t + 2 it
    passes the crossbar, in t + 3 it is on the next wire. If routers take one cycle, it passes the crossbar in t + 1 and
    is on the next wire in t + 2. Its entry is free at once: the credit is on the wire back in t + 2.

    Each kind of message has ``routing.virtual_channels`` channels of its own at each port; kind m begins at m times
    that number. Packets of a kind leave the network at their node one after the other, on the kind's first channel.

    Ports are numbered ``node * ports + port``, queues ``port * channels + channel``. The caller
    serves the ports without a neighbour, among them the port of the node itself.

    Parameters
    ----------
    routing
        Routing tables.
    buffer_flits
        Entries of a queue.
    messages
        Kinds of messages; kinds do not block each other.
    arbitration
        One of `ARBITRATIONS`: round-robin, or the longest waiting.
    router_cycles
        Cycles in a router, 1 or 2.
    copies
        Number of networks; the nodes of copy c begin at c times their number. Destinations count within a copy.
    alone
        Only this node's router, without neighbours.

    Raises
    ------
    InputError
        Arbitration or router cycles are unknown, or entries or kinds out of range.
    TypeError
        Entries or kinds are no int.

    Source: Shen 1993, section 5.2.3.
    """

    def __init__(self, routing: Routing, *, buffer_flits: int, messages: int = 1,
                 arbitration: str = "round-robin", router_cycles: int = 2, copies: int = 1, alone: int | None = None):
        check_routers(buffer_flits=buffer_flits, messages=messages, arbitration=arbitration,
                      router_cycles=router_cycles)
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

        # The next queue of each packet in a queue, in terms of this router's output ports, by destination.
        node, _, came = (axis[..., None] for axis in np.ogrid[:nodes, :ports, :self.channels])
        output, channel = output[:, None, None, :], channel[:, None, None, :]
        channel = channel + came // per_kind * per_kind
        target = (node * ports + output) * self.channels + channel
        target = np.broadcast_to(target, (nodes, ports, *target.shape[2:])).reshape(count // copies, -1)
        self._target = np.concatenate([target + copy * len(target) for copy in range(copies)])

        # From an output port to the input port at the link's other end, and back.
        copy = np.arange(copies)[:, None, None] * nodes
        self._behind = np.where(behind == NOWHERE, NOWHERE,
                                (behind + copy) * ports + np.array(routing.topology.opposite)).reshape(-1)
        self._before = np.full_like(self._behind, NOWHERE)
        linked = np.flatnonzero(self._behind != NOWHERE)
        self._before[self._behind[linked]] = linked

        self._flit, self._next_queue = (np.zeros((count, buffer_flits), dtype=np.int64) for _ in range(2))
        self._head, self._level = (np.zeros(count, dtype=np.int64) for _ in range(2))
        self._credits = np.full(count, buffer_flits, dtype=np.int64)
        self._holder = np.full(count, _FREE, dtype=np.int64)
        self._round_robin = arbitration == "round-robin"
        self._last_granted = np.full(self.nodes * ports, self._queues_of_node - 1, dtype=np.int64)
        # Age of each queue's first flit: cycles since it became the first.
        self._waited = np.zeros(count, dtype=np.int64)
        # Grants of the cycles before, the oldest first.
        self._granted = deque([(_NONE, _NONE)] * router_cycles)
        self._returned = _NONE
        # Flits sent, to links and to nodes; cycles in which a port had a request and granted none.
        self.sent = self.stalls = 0
        self._index = np.arange(count) % self._queues_of_node

    @property
    def level(self) -> np.ndarray:
        """Flits in each queue."""
        return self._level

    def wires(self) -> Wires:
        """Flits and credits that the routers drive onto their wires in the present cycle."""
        queues, flits = self._granted[0]
        return Wires(queues=queues, flits=flits, credits=self._returned)

    def step(self, flits: Flits, *, queues: np.ndarray = _NONE, entering: np.ndarray = _NONE,
             credits: np.ndarray = _NONE) -> None:
        """The end of a cycle.

        Parameters
        ----------
        flits
            All flits of the run.
        queues, entering
            Queues and flits on the wires to the ports that the caller serves, at most one flit per port.
        credits
            Output queues of those ports for which the caller returns a credit.
        """
        wires = self.wires()
        left, now = self._grant(flits)

        channel, port = wires.credits % self.channels, wires.credits // self.channels
        before = self._before[port]
        linked = before != NOWHERE
        self._credits[before[linked] * self.channels + channel[linked]] += 1
        # The caller may return several credits of a queue in one cycle.
        np.add.at(self._credits, credits, 1)

        channel, port = wires.queues % self.channels, wires.queues // self.channels
        behind = self._behind[port]
        linked = behind != NOWHERE
        queues = np.concatenate([behind[linked] * self.channels + channel[linked], queues])
        entering = np.concatenate([wires.flits[linked], entering])
        entry = (self._head[queues] + self._level[queues]) % self.buffer_flits
        self._flit[queues, entry] = entering
        self._next_queue[queues, entry] = self._target[queues, flits.destination[entering]]
        self._level[queues] += 1

        self._granted.popleft()
        self._granted.append(now)
        self._returned = left

    def _grant(self, flits):
        """The queues granted, and the next queues and flits of the grants."""
        busy = np.flatnonzero(self._level)
        first, target = self._flit[busy, self._head[busy]], self._next_queue[busy, self._head[busy]]
        eligible = self._credits[target] > 0
        eligible &= self._holder[target] == np.where(flits.first[first], _FREE, busy)
        requested = target // self.channels
        queue, port = busy[eligible], requested[eligible]
        index = self._index[queue]
        # The lowest priority number is granted.
        if self._round_robin:
            priority = (index - self._last_granted[port] - 1) % self._queues_of_node
        else:
            priority = index - self._queues_of_node * self._waited[queue]
            self._waited[busy] += 1
        order = np.lexsort((priority, port))
        chosen = order[np.flatnonzero(np.diff(port[order], prepend=NOWHERE))]
        ports, queues = port[chosen], queue[chosen]

        self.sent += len(ports)
        self.stalls += np.count_nonzero(np.bincount(requested)) - len(ports)
        self._last_granted[ports] = index[chosen]
        self._waited[queues] = 0
        granted, targets = first[eligible][chosen], target[eligible][chosen]
        self._head[queues] = (self._head[queues] + 1) % self.buffer_flits
        self._level[queues] -= 1
        self._credits[targets] -= 1
        self._holder[targets] = np.where(flits.last[granted], _FREE, queues)
        return queues, (targets, granted)
