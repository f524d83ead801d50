from itertools import product

import numpy as np
import pytest

from benchmarks.traffic import PATTERNS
from golden.base.errors import InputError
from golden.engine.config import PRESETS
from golden.engine.noc.delay import zero_load_latency
from golden.engine.noc.network import Network as Model
from golden.engine.noc.routing import Routing, route
from golden.engine.noc.topology import Topology
from hw.lib.arbiter import ArbiterPolicy
from hw.noc.network import Network
from hw.noc.router import Router
from tb.lib.drawn import drawn
from tb.lib.runner import ICARUS
from tb.lib.seed import SEED
from tb.lib.simulator import simulator_of
from tb.lib.timing import documented_latency
from tb.noc.packets import packets, stalls
from tb.noc.replay import Words, replay, script

# Flits per node and cycle: queues that are empty now and then, and queues that are full.
LOADS = (0.4, 1.0)
POLICIES = {"round-robin": ArbiterPolicy.ROUND_ROBIN, "age": ArbiterPolicy.LONGEST_WAITING}


def seeded(*more):
    return np.random.default_rng([SEED, *more])


def scripts_of(routing, *, flits, messages, bits, depth, arbitration, router_cycles):
    """Runs of the model, one of each pattern and load."""
    nodes, found = routing.topology.nodes, []
    for number, (pattern, load) in enumerate(product(PATTERNS, LOADS)):
        generator = seeded(number, flits, nodes)
        given = packets(generator, routing.topology, pattern, flits=flits, load=load, messages=messages)
        arrivals = Model(
            routing, buffer_flits=depth, messages=messages, arbitration=arbitration, router_cycles=router_cycles).run(
            given, cycles=100_000, source_stalls=stalls(generator, nodes, 0.1),
            sink_stalls=stalls(generator, nodes, 0.2))
        found.append(script(generator, given, arrivals, nodes=nodes, bits=bits,
                            channels=messages * routing.virtual_channels))
    return found


def check(name, columns, rows, channels, messages, bits, depth, arbitration, router_cycles, *, simulator, flits):
    routing = route(Topology(name, columns, rows), channels)
    network = Network(routing=routing, bits=bits, depth=depth, messages=messages, router_cycles=router_cycles,
                      policy=POLICIES[arbitration])
    replay(network, scripts_of(routing, flits=flits, messages=messages, bits=bits, depth=depth,
                               arbitration=arbitration, router_cycles=router_cycles),
           simulator=simulator,
           name=f"network-{name}-{columns}x{rows}-{channels}-{messages}-{bits}-{router_cycles}-{flits}")


# Topology, columns, rows, channels, kinds of messages, bits of a flit, entries of a queue, arbitration, cycles of a
# router.
SMALL = [("mesh", 2, 1, 1, 2, 16, 1, "age", 1), ("torus", 3, 2, 2, 1, 16, 5, "round-robin", 2),
         ("ring", 3, 2, 2, 1, 16, 5, "round-robin", 2), ("torus", 3, 2, 4, 1, 16, 5, "round-robin", 1),
         ("hypercube", 4, 2, 1, 2, 16, 3, "age", 1)]
RING = ("ring", 4, 1, 2, 1, 16, 5, "round-robin", 2)
LARGE = [("mesh", 4, 4, 1, 1, 32, 8, "round-robin", 2), ("torus", 4, 4, 4, 1, 32, 8, "round-robin", 1),
         ("hypercube", 4, 4, 1, 2, 32, 8, "age", 1), ("ring", 4, 2, 2, 1, 73, 8, "round-robin", 2),
         ("mesh", 4, 4, 4, 1, 72, 8, "round-robin", 2), ("mesh", 5, 3, 2, 2, 32, 3, "age", 2),
         ("torus", 4, 4, 2, 1, 32, 8, "age", 2), ("ring", 8, 1, 2, 2, 32, 8, "round-robin", 2),
         ("illiac", 4, 4, 2, 1, 32, 8, "round-robin", 2), ("mesh", 8, 8, 1, 1, 32, 8, "round-robin", 2)]


@pytest.mark.sim
def test_every_flit_in_its_cycle():
    check(*RING, simulator="verilator", flits=200)


@pytest.mark.sim
def test_a_wrong_bit_is_noticed(monkeypatch):
    right = scripts_of

    def wrong(*given, **more):
        (one, *others) = right(*given, **more)
        words = one["required"]
        return [one | {"required": [word ^ (number == len(words) // 2) for number, word in enumerate(words)]}, *others]

    monkeypatch.setattr(f"{__name__}.scripts_of", wrong)
    with pytest.raises(pytest.fail.Exception, match="as_the_model_says failed"):
        # Not the files of the test before, which may run at the same time.
        check(*RING, simulator="verilator", flits=150)


@pytest.mark.parametrize("simulator", [ICARUS])
@pytest.mark.parametrize("network", SMALL, ids=str)
def test_every_flit_in_its_cycle_in_icarus(network, simulator):
    check(*network, simulator=simulator, flits=200)


@pytest.mark.sim
def test_every_flit_of_a_large_network_in_its_cycle():
    check(*LARGE[0], simulator="verilator", flits=1_500)


@pytest.mark.nightly
@pytest.mark.parametrize("network", drawn(LARGE, 4), ids=str)
def test_every_flit_of_long_runs_in_its_cycle(network):
    check(*network, simulator="verilator", flits=15_000)


class Numbered(Router):
    """A router of any node that is given its own as an input."""

    def __init__(self, *, node, **given):
        super().__init__(node=None, **given)
        self._number = node

    def elaborate(self, platform):
        m = super().elaborate(platform)
        m.d.comb += self.node.eq(self._number)
        return m


@pytest.mark.parametrize("network", [("mesh", 2, 2, 1, 1), ("torus", 4, 1, 2, 2)], ids=str)
def test_routers_of_any_node_are_those_of_each_node(network, monkeypatch):
    """Every flit comes in its cycle; exports of routers have their node as an input."""
    monkeypatch.setattr("hw.noc.network.Router", Numbered)
    *shape, channels, messages = network
    routing, shared = route(Topology(*shape), channels), {"messages": messages, "router_cycles": 2}
    harness = Words(Network(routing=routing, bits=8, depth=3, **shared))
    (one, *_) = scripts_of(routing, flits=150, bits=8, depth=3, arbitration="round-robin", **shared)
    simulator = simulator_of(harness)

    async def drive(ctx):
        for cycle, (word, expected) in enumerate(zip(one["given"], one["required"], strict=True)):
            assert ctx.get(harness.o) == expected, cycle
            ctx.set(harness.i, word)
            await ctx.tick()

    simulator.add_testbench(drive)
    simulator.run()


@pytest.mark.parametrize("router_cycles", [1, 2])
def test_a_single_packet_has_the_zero_load_latency(router_cycles):
    routing = route(Topology("mesh", 3, 1), 1)
    network = Network(routing=routing, bits=8, depth=2, router_cycles=router_cycles)
    simulator = simulator_of(network)
    seen = []

    async def send(ctx):
        """Two flits from node 0 to node 2."""
        for number, data in enumerate((0b101110, 0)):
            ctx.set(network.i[0].payload.flit, {"data": data, "first": number == 0, "last": number == 1})
            ctx.set(network.i[0].valid, 1)
            await ctx.tick()
        ctx.set(network.i[0].valid, 0)
        await ctx.tick().repeat(20)
        assert ctx.get(network.flits) == 2 * 3
        assert ctx.get(network.stalls) == 0

    async def watch(ctx):
        for cycle in range(22):
            if ctx.get(network.o[2].valid):
                seen.append((cycle, ctx.get(network.o[2].payload.flit.data)))
            await ctx.tick()

    simulator.add_testbench(send)
    simulator.add_testbench(watch)
    simulator.run()
    latency = documented_latency(Network, PRESETS["tiny"].replace({"noc.router_cycles": router_cycles}), hops=2)
    assert seen == [(latency, 0b101110), (latency + 1, 0)]
    # The law counts both ends: from the cycle before the first wire.
    assert latency + 1 == zero_load_latency(2, router_cycles=router_cycles)


def test_counters_are_those_of_the_model():
    routing = route(Topology("mesh", 2, 2), 1)
    network, model = Network(routing=routing, bits=8, depth=2), Model(routing, buffer_flits=2)
    given = packets(seeded(9), routing.topology, "hotspot", flits=200, load=0.8)
    arrivals = model.run(given, cycles=5000)
    words = script(seeded(10), given, arrivals, nodes=4, bits=8, channels=1)["given"]
    harness = Words(network)
    simulator = simulator_of(harness)

    async def drive(ctx):
        for word in words:
            ctx.set(harness.i, word)
            await ctx.tick()
        assert ctx.get(network.flits) == model.routers.sent
        assert ctx.get(network.stalls) == model.routers.stalls > 0

    simulator.add_testbench(drive)
    simulator.run()


def test_init_refuses_channels_that_could_wait_for_each_other():
    good = route(Topology("ring", 8, 1), 2)
    routing = Routing(topology=good.topology, virtual_channels=2, port=good.port, channel=np.zeros_like(good.channel),
                      entry=good.entry)
    with pytest.raises(InputError, match=r"can deadlock: .* -> .* -> "):
        Network(routing=routing, bits=16, depth=4)
