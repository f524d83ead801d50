"""Clusters at a patch network: each sends requests to all others, answers theirs, and takes its replies."""

import random
from collections import defaultdict
from functools import partial
from itertools import repeat

import cocotb
from cocotb.triggers import ClockCycles

from golden.engine.config import PRESETS
from golden.engine.noc.packing import VERTICES
from hw.formats import Formats
from hw.noc.network_fault import NetworkFault
from hw.noc.patch_network import PatchNetwork
from tb.lib.clocking import start
from tb.lib.ports import Ports
from tb.lib.responder import Responder
from tb.lib.runner import options

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
        given, config = options(), _config()
        self.nodes, patches, draw = config.noc.nodes, 1 << config.icu.patch_bits, random.Random(given["seed"])
        # Three in four go to the first cluster: what waits for it fills the network, however large.
        self.requests = [[{"node": draw.choice((0, 0, 0, draw.randrange(self.nodes))), "patch": draw.randrange(patches)}
                          for _ in range(given["requests"])] for _ in range(self.nodes)]
        # Clusters that take no reply.
        self.stopped = set()
        limit = (1 << Formats(config).scene_vector.elem_shape.width) - 1
        self._vertex = lambda node, patch, number: [
            (patch * 40503 + node * 9973 + number * 257 + axis * 65537) & limit for axis in range(3)]
        self.ports = Ports(dut, PatchNetwork(config=config), stalls={
            **{f"o_reply__{node}": self._stalls(node) for node in range(self.nodes)},
            **{f"o_request__{node}": iter(partial(self._is_replying, node), None) for node in range(self.nodes)}})
        self.ports.respond(*(Responder(f"o_request__{node}", f"i_reply__{node}", partial(self._answer, node))
                             for node in range(self.nodes)))

    def go(self) -> None:
        """Begin."""
        for node, requests in enumerate(self.requests):
            self.ports.taken(f"i_reply__{node}")
            self.ports.begin(f"i_request__{node}", requests)

    def _stalls(self, node):
        """Half of all cycles at random, now and then long ones, and while it is stopped."""
        generator = random.Random(node)
        while True:
            yield from repeat(True, generator.choice((1, 1, 1, 40)) if generator.random() < 0.5 else 0)
            yield node in self.stopped

    def _is_replying(self, node):
        ports = self.ports
        return len(ports.taken(f"i_reply__{node}").items) < VERTICES * len(ports.sinks[f"o_request__{node}"].items)

    def _answer(self, node, request):
        return [{"node": request["node"], "vertex": vertex} for vertex in self._reply(node, request["patch"])]

    def _reply(self, node, patch):
        """The vertices of a patch that a cluster holds."""
        return [{"patch": patch, "surface": node, "vertex": self._vertex(node, patch, number)}
                for number in range(VERTICES)]

    def done(self, nodes) -> bool:
        """Whether these clusters have all that they requested."""
        return all(len(self.ports.sinks[f"o_reply__{node}"].items) == VERTICES * len(self.requests[node])
                   for node in nodes)

    def check(self) -> None:
        """Each request has come once, each reply once and whole, and those of any two clusters in order."""
        for node, requests in enumerate(self.requests):
            expected, got = defaultdict(list), defaultdict(list)
            for request in requests:
                expected[request["node"]] += [request["patch"]]
            replies = self.ports.came(f"o_reply__{node}")
            for first in range(0, len(replies), VERTICES):
                vertices = replies[first:first + VERTICES]
                home, patch = vertices[0]["surface"], vertices[0]["patch"]
                assert vertices == self._reply(home, patch), f"cluster {node} got a reply that is not whole"
                got[home].append(patch)
            assert got == expected, f"cluster {node} did not get what it requested, in order"
            for to in range(self.nodes):
                assert [request["patch"] for request in self.ports.came(f"o_request__{to}")
                        if request["node"] == node] == expected[to]
            assert self.ports[f"fault__{node}"] == NetworkFault.NONE.value


def _config():
    return PRESETS["tiny"].replace(options()["config"])


async def prepared(dut):
    """The clusters after a reset, and the cycles in which all must be over."""
    cycles = 2000 + 20 * options()["requests"] * _config().noc.nodes
    await start(dut, cycles=2 * cycles)
    return Clusters(dut), cycles


@cocotb.test()
async def all_are_answered(dut):
    """Both networks are full, all clusters accept slowly, and yet all requests are answered; also after a reset."""
    clusters, cycles = await prepared(dut)
    clusters.go()
    await ClockCycles(dut.clk, 300)
    await clusters.ports.reset()
    clusters.go()
    took = 0
    while not clusters.done(range(clusters.nodes)):
        await ClockCycles(dut.clk, 50)
        took += 50
        assert took < cycles, f"{took} cycles, and some clusters wait"
    clusters.check()
    stalls = clusters.ports["stalls"]
    assert stalls > took * clusters.nodes / 8, f"the network is not full: {stalls} stalls in {took} cycles"


@cocotb.test()
async def a_stalled_cluster_blocks_no_other(dut):
    """A cluster that takes no reply answers all the same, and all others get what they have requested."""
    clusters, cycles = await prepared(dut)
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
