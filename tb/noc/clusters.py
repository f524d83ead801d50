"""Clusters at a patch network: each sends requests to all others, answers theirs, and takes its replies."""

import random
from collections import defaultdict
from itertools import repeat

import cocotb
from cocotb.triggers import ClockCycles, RisingEdge

from golden.config import PRESETS
from golden.noc.packing import VERTICES
from hw.formats import Formats
from hw.noc.network_interface import interface_members
from tb.lib.clocking import reset, start
from tb.lib.payload import pack, unpack
from tb.lib.runner import options
from tb.lib.stream import Sink, Source

__all__ = ["Clusters"]


class Clusters:
    """All clusters of a network, each with requests of its own to all of them.

    A cluster takes a request only when the reply to the one before has gone: so requests wait for replies wherever they
    can. Its replies it takes slowly.

    Parameters
    ----------
    dut
        A `hw.noc.patch_network.PatchNetwork`.
    """

    def __init__(self, dut):
        given = options()
        self.dut, self._random = dut, random.Random(given["seed"])
        self._config = PRESETS["tiny"].replace(given["config"])
        self.nodes = self._config.noc.nodes
        members = interface_members(self._config, self.nodes)
        self._shape = {name: member.signature.members["payload"].shape for name, member in members.items()
                       if member.is_signature}
        patches = 1 << self._config.icu.patch_bits
        # Three in four go to the first cluster: what waits for it fills the network, however large.
        self.requests = [[(self._random.choice((0, 0, 0, self._random.randrange(self.nodes))),
                           self._random.randrange(patches))
                          for _ in range(given["requests"])] for _ in range(self.nodes)]
        # The requests of each cluster, in the order in which they came.
        self.requested = [[] for _ in range(self.nodes)]
        self._tasks, self.sinks = [], []
        # Cycles in which all must be over.
        self.timeout = 2000 + 20 * given["requests"] * self.nodes
        # Clusters that take no reply.
        self.stopped = set()
        limit = (1 << Formats(self._config).scene_vector.elem_shape.width) - 1
        self._vertex = lambda node, patch, number: [
            (patch * 40503 + node * 9973 + number * 257 + axis * 65537) & limit for axis in range(3)]

    def go(self) -> None:
        """Begin."""
        for node in range(self.nodes):
            requester = Source(self.dut, f"i_request__{node}")
            items = [pack(self._shape["i_request"], {"node": to, "patch": patch}) for to, patch in self.requests[node]]
            self._tasks += [cocotb.start_soon(requester.send(items)), cocotb.start_soon(self._serve(node))]
            self.sinks.append(Sink(self.dut, f"o_reply__{node}", stalls=self._stalls(node)))

    def _stalls(self, node):
        """Half of all cycles at random, now and then long ones, and while it is stopped."""
        generator = random.Random(node)
        while True:
            yield from repeat(True, generator.choice((1, 1, 1, 40)) if generator.random() < 0.5 else 0)
            yield node in self.stopped

    def stop(self) -> None:
        """All of them."""
        for task in self._tasks:
            task.cancel()
        for sink in self.sinks:
            sink.stop()
        for node in range(self.nodes):
            for name in "i_request", "i_reply":
                getattr(self.dut, f"{name}__{node}__valid").value = 0
        self._tasks, self.sinks, self.requested = [], [], [[] for _ in range(self.nodes)]

    async def _serve(self, node):
        """Requests one after the other, each with its reply."""
        edge = RisingEdge(self.dut.clk)
        valid, ready, payload = (getattr(self.dut, f"o_request__{node}__{name}")
                                 for name in ("valid", "ready", "payload"))
        reply = Source(self.dut, f"i_reply__{node}")
        while True:
            ready.value = 1
            await edge
            while not int(valid.value):
                await edge
            ready.value = 0
            came = unpack(self._shape["o_request"], int(payload.value))
            self.requested[node].append((came["node"], came["patch"]))
            await reply.send(pack(self._shape["i_reply"], {"node": came["node"], "vertex": vertex})
                             for vertex in self._reply(node, came["patch"]))

    def _reply(self, node, patch):
        """The vertices of a patch that a cluster holds."""
        return [{"patch": patch, "surface": node, "vertex": self._vertex(node, patch, number)}
                for number in range(VERTICES)]

    def done(self, nodes) -> bool:
        """Whether these clusters have all that they requested."""
        return all(len(self.sinks[node].items) == VERTICES * len(self.requests[node]) for node in nodes)

    def check(self) -> None:
        """Each request has come once, each reply once and whole, and those of any two clusters in order."""
        for node, requests in enumerate(self.requests):
            expected, got = defaultdict(list), defaultdict(list)
            for to, patch in requests:
                expected[to] += [patch]
            replies = [unpack(self._shape["o_reply"], item) for item in self.sinks[node].items]
            for first in range(0, len(replies), VERTICES):
                vertices = replies[first:first + VERTICES]
                home, patch = vertices[0]["surface"], vertices[0]["patch"]
                assert vertices == self._reply(home, patch), f"cluster {node} got a reply that is not whole"
                got[home].append(patch)
            assert got == expected, f"cluster {node} did not get what it requested, in order"
            for to, requested in enumerate(self.requested):
                assert [patch for source, patch in requested if source == node] == expected[to]
            assert not int(getattr(self.dut, f"fault__{node}").value)


@cocotb.test()
async def all_are_answered(dut):
    """Both networks are full, all clusters accept slowly, and yet all requests are answered; also after a reset."""
    clusters = Clusters(dut)
    cycles = clusters.timeout
    await start(dut, cycles=2 * cycles)
    clusters.go()
    await ClockCycles(dut.clk, 300)
    clusters.stop()
    await reset(dut)
    clusters.go()
    took = 0
    while not clusters.done(range(clusters.nodes)):
        await ClockCycles(dut.clk, 50)
        took += 50
        assert took < cycles, f"{took} cycles, and some clusters wait"
    clusters.check()
    stalls = int(dut.stalls.value)
    assert stalls > took * clusters.nodes / 8, f"the network is not full: {stalls} stalls in {took} cycles"


@cocotb.test()
async def a_stalled_cluster_blocks_no_other(dut):
    """A cluster that takes no reply answers all the same, and all others get what they have requested."""
    clusters = Clusters(dut)
    cycles = clusters.timeout
    await start(dut, cycles=2 * cycles)
    clusters.stopped = {0}
    clusters.go()
    for _ in range(cycles // 50):
        await ClockCycles(dut.clk, 50)
        if clusters.done(range(1, clusters.nodes)):
            break
    done = clusters.done(range(1, clusters.nodes))
    assert done == options()["progress"], f"the others are {'' if done else 'not '}done"
    if done:
        clusters.stopped = set()
        while not clusters.done([0]):
            await ClockCycles(dut.clk, 50)
        clusters.check()
