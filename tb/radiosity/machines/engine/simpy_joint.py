"""Clusters that cast together, in SimPy, as a reference of `radiosity.machines.engine.joint_cast`.

Their networks are those of `radiosity.machines.engine.packet_network`, which are compared with
`golden.engine.noc.network`.
"""

from collections import deque

import numpy as np
import simpy

from golden.engine.memsys.bus.cache import Cache
from radiosity.machines.engine.joint_cast import JointCast
from radiosity.machines.engine.packet_network import Count, Packet, network_cycle, packet_network, send
from tb.radiosity.machines.engine.simpy_cluster import SimpyCluster

__all__ = ["SimpyBus", "simpy_joint"]


def simpy_joint(traces, home, timing, joint, *, routing, slots, run_ahead, bus=None, memsys=None, kept=(),
                store=None, stores=(), in_order=False, **network):
    """What `joint_cast` finds; ``network`` are the other parameters of its networks."""
    path = bus and SimpyBus(bus, memsys, len(traces), kept)
    made = _Joint(traces, home, timing, joint, routing, slots, run_ahead, path, store, stores, in_order, network)
    made.run()
    return JointCast(times=tuple(cluster.times() for cluster in made.clusters), owner=tuple(made.owner),
                     deferred=np.array([sum(number == cluster for cluster, _ in made.keeps)
                                        for number in range(len(traces))]),
                     reads=len(path.fetches) if path else 0)


class SimpyBus:
    """The bus, with golden's own cache; parameters as `radiosity.machines.engine.bus_path.bus_path` has them."""

    def __init__(self, timing, memsys, clusters, kept):
        self.timing, self._cache = timing, Cache.of(memsys, lines=memsys.patch_lines)
        self._cache.access(kept)
        self._waiting = [deque() for _ in range(clusters)]
        # When patches could be read: all of them, and those fetched.
        self._answers, self.fetches = [], []

    @property
    def is_active(self):
        """Whether a request waits."""
        return any(self._waiting)

    def ask(self, cluster, patch, made):
        """A request that may be granted from a cycle on."""
        self._waiting[cluster].append((made, cluster, patch))

    def grant(self, cycle):
        """The request granted in a cycle: its cluster, and when its patch can be read."""
        made, cluster, patch = min((queue[0] for queue in self._waiting if queue), default=(cycle + 1, None, None))
        if made > cycle:
            return None
        self._waiting[cluster].popleft()
        timing, answers, fetches = self.timing, self._answers, self.fetches
        begin = max([cycle, *([answers[-timing.requests]] if len(answers) >= timing.requests else [])])
        hit = self._cache.access([patch])[0][0]
        ready = [begin + (timing.hit if hit else timing.fetch)]
        if not hit:
            ready += [last + timing.words for last in fetches[-1:]]
            ready += [fetches[-timing.fetches] + timing.next_fetch] if len(fetches) >= timing.fetches else []
            fetches.append(max(ready))
        answers.append(max([*ready, *(last + timing.beats for last in answers[-1:])]))
        return cluster, answers[-1]


class _Network:
    """A network, and what each packet in it is about."""

    def __init__(self, routing, packets, network):
        self._network = packet_network(routing, packets=packets, **network)
        self._unused, self._about = list(range(packets)), {}

    @property
    def is_active(self):
        """Whether a packet has not arrived."""
        return self._network.counts[Count.UNARRIVED] > 0

    def send(self, source, destination, length, made, patch):
        """A packet that may enter from a cycle on."""
        packet = self._unused.pop()
        self._about[packet] = source, destination, patch
        self._network.packets[packet, :Packet.ENTERED] = source, destination, length, made
        send(self._network, packet)

    def cycle(self, cycle):
        """Source, destination and patch of the packets that have left in a cycle."""
        if not self.is_active:
            return []
        network_cycle(self._network, cycle)
        taken = self._network.taken[:self._network.counts[Count.TAKEN_NOW]].tolist()
        self._unused += taken
        return [self._about.pop(packet) for packet in taken]


class _Joint:
    """Clusters, networks and a bus with one clock."""

    def __init__(self, traces, home, timing, joint, routing, slots, run_ahead, bus, store, stores, in_order, network):
        # Of patch stores: their patches that are kept when they come, and when the last one left a frame.
        self._store, self.keeps, self._left = store, set(), [0] * len(traces)
        self._bus, self._fetched = bus, [deque() for _ in traces]
        self._joint, self._timing, self._env = joint, timing, simpy.Environment()
        self._requests, self._replies = (_Network(routing, len(traces) * joint.outstanding, network) for _ in range(2))
        self._served = [0] * len(traces)
        # Of each store that keeps the order of its requests: those that have not left it, and what has come.
        self._in_order, self._requested, self._come = in_order, [], [set() for _ in traces]
        self.clusters, self.owner = [], []
        for number, trace in enumerate(traces):
            held = np.broadcast_to(home, (len(traces), home.shape[-1]))[number, trace.patch]
            owner = np.where(held == number, -1, np.where(held < 0, -2, held))
            for place in np.flatnonzero(owner != -1) if store else ():
                patch = int(trace.patch[place])
                if stores[number].request(patch):
                    owner[place] = -3
                elif patch in stores[number]:
                    self.keeps.add((number, place))
            self.owner.append(owner)
            self._requested.append(deque(np.flatnonzero(owner != -1).tolist()))
            self.clusters.append(SimpyCluster(
                self._env, trace, timing, slots, run_ahead, owner=owner,
                store=store, most=(joint.outstanding, bus.timing.outstanding if bus else 0,
                                   store.requests if store else 0),
                asks=(lambda patch, number=number, owner=owner: self._ask(number, int(owner[patch]), patch),
                      lambda patch, number=number, trace=trace: self._ask_bus(number, trace, patch),
                      lambda patch, number=number: self._leave(number, patch, store.kept - store.lookup))))

    def run(self):
        """Cycle by cycle until nothing is left to happen."""
        cycle = 0
        parts = [self._requests, self._replies, *([self._bus] if self._bus else [])]
        while self._env.peek() != simpy.core.Infinity or any(part.is_active for part in parts):
            while self._env.peek() <= cycle:
                self._env.step()
            for source, owner, patch in self._requests.cycle(cycle):
                # Its owner serves it after those before it.
                begin = max(cycle + self._joint.serve, self._served[owner])
                self._served[owner] = begin + self._joint.port
                self._replies.send(owner, source, self._joint.reply_flits, begin, patch)
            for _, number, patch in self._replies.cycle(cycle):
                self._env.process(self._arrive(number, patch, cycle + self._joint.reply))
            granted = self._bus and self._bus.grant(cycle)
            if granted:
                number, ready = granted
                self._env.process(self._arrive(number, self._fetched[number].popleft(), ready))
            cycle += 1

    def _ask(self, number, owner, patch):
        self._requests.send(number, owner, self._joint.request_flits, self._env.now + self._joint.request, patch)

    def _ask_bus(self, number, trace, patch):
        self._fetched[number].append(patch)
        self._bus.ask(number, int(trace.patch[patch]), self._env.now + self._bus.timing.request)

    def _arrive(self, number, patch, cycle):
        yield self._env.timeout(cycle - self._env.now)
        if self._store is None:
            self.clusters[number].arrive(patch)
        elif (number, patch) in self.keeps:
            self._leave(number, patch, self._store.stored)
        else:
            self._env.process(self._enter(number, patch, self._env.now + self._store.passed))

    def _leave(self, number, patch, cycles):
        """A patch leaves its frame, a patch at a time."""
        self._left[number] = max(self._env.now + cycles, self._left[number] + self._store.vertices)
        self._env.process(self._enter(number, patch, self._left[number]))

    def _enter(self, number, patch, cycle):
        # Before all else that happens then.
        leaves = self._env.event()
        leaves._ok, leaves._value = True, None
        self._env.schedule(leaves, priority=simpy.events.URGENT, delay=cycle - self._env.now)
        yield leaves
        come, requested = self._come[number], self._requested[number] if self._in_order else deque([patch])
        come.add(patch)
        while requested and requested[0] in come:
            self.clusters[number].arrive(requested.popleft())
