"""Clusters that cast together, in SimPy, as a reference of `golden.machines.joint_cast`."""

import numpy as np
import simpy

from tb.golden.machines.simpy_cluster import SimpyCluster
from tb.golden.machines.simpy_network import Packet, SimpyNetwork, cycles

__all__ = ["simpy_joint"]


def simpy_joint(traces, home, timing, joint, *, routing, slots, run_ahead, **network):
    """The times of `golden.machines.joint_cast.joint_cast`; ``network`` are the other parameters of its networks."""
    made = _Joint(traces, home, timing, joint, routing, slots, run_ahead, network)
    made.run()
    return [cluster.times() for cluster in made.clusters]


class _Joint:
    """Clusters with a clock of cycles, and networks with one of instants that is a cycle behind."""

    def __init__(self, traces, home, timing, joint, routing, slots, run_ahead, network):
        self._joint, self._timing, self._env, self._wires = joint, timing, simpy.Environment(), simpy.Environment()
        self._requests, self._replies = (SimpyNetwork(self._wires, routing, deliver=deliver, messages=1, **network)
                                         for deliver in (self._serve, self._return))
        self._patches, self._served, self._unarrived = {}, [0] * len(traces), 0
        self.clusters = []
        for number, trace in enumerate(traces):
            owner = np.where(home[trace.patch] == number, -1, home[trace.patch])
            self.clusters.append(SimpyCluster(
                self._env, trace, timing, slots, run_ahead, owner=owner, most=joint.outstanding,
                ask=lambda patch, number=number, owner=owner: self._ask(number, int(owner[patch]), patch)))

    def run(self):
        """Cycle by cycle until nothing is left to happen."""
        cycle = 0
        while self._env.peek() != simpy.core.Infinity or self._unarrived:
            while self._env.peek() <= cycle:
                self._env.step()
            while self._wires.peek() < cycles(cycle + 1):
                self._wires.step()
            cycle += 1

    def _ask(self, number, owner, patch):
        packet = Packet(source=number, destination=owner, length=self._joint.request_flits, message=0)
        self._patches[packet] = patch
        self._unarrived += 1
        self._send(self._requests, packet, self._env.now + self._joint.request)

    def _serve(self, request):
        """A request has left the network: its owner serves it after those before it."""
        owner = request.destination
        begin = max(request.taken + self._joint.serve, self._served[owner])
        self._served[owner] = begin + self._timing.vertices
        reply = Packet(source=owner, destination=request.source, length=self._joint.reply_flits, message=0)
        self._patches[reply] = self._patches.pop(request)
        self._send(self._replies, reply, begin)

    def _return(self, reply):
        """A reply has left the network."""
        self._unarrived -= 1
        self._env.process(self._arrive(reply.destination, self._patches.pop(reply), reply.taken + self._joint.reply))

    def _arrive(self, number, patch, cycle):
        yield self._env.timeout(cycle - self._env.now)
        self.clusters[number].arrive(patch)

    def _send(self, network, packet, made):
        """From the first instant of a cycle on; at the last one of the cycle before it is known."""
        def wait():
            yield self._wires.timeout(cycles(made) - 1 - self._wires.now)
            network.send(packet)
        self._wires.process(wait())
