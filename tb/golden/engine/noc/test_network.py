"""Every packet arrives once, complete, at its destination, and in order."""

import numpy as np
import pytest

from benchmarks.traffic import PATTERNS
from golden.base.errors import InputError
from golden.engine.noc.network import NEVER, Network, Packets
from golden.engine.noc.router import ARBITRATIONS, Routers
from golden.engine.noc.routing import route
from golden.engine.noc.topology import TOPOLOGIES, Topology
from tb.golden.engine.noc.networks import networks, starts
from tb.noc.packets import packets, stalls


def check(routing, given, arrivals, messages, router_cycles=2):
    """All flits have arrived, packets of a kind one after the other, and of any two nodes in order."""
    assert (arrivals.taken != NEVER).all()
    assert np.array_equal(arrivals.packet, np.repeat(np.arange(len(given)), given.length))
    hops = routing.hops[given.source, given.destination][arrivals.packet]
    assert (arrivals.left - arrivals.entered >= (router_cycles + 1) * (hops + 1)).all()
    assert (arrivals.taken > arrivals.left).all()
    # A queue is left in order, at most a flit in a cycle, at the earliest in the cycle after its entry.
    entered = np.stack([arrivals.entered, given.source[arrivals.packet], arrivals.entry], axis=1)
    entered, back = (rows[np.lexsort(rows.T)] for rows in (entered, arrivals.credits))
    assert np.array_equal(back[:, 1:], entered[:, 1:]), "a credit for each flit"
    assert (back[:, 0] - entered[:, 0] >= 2).all()
    assert len(np.unique(back, axis=0)) == len(back)
    # At each node and for each kind: the order in which flits come out.
    row = given.destination * messages + given.message
    order = np.lexsort((arrivals.left, row[arrivals.packet]))
    of, at = arrivals.packet[order], row[arrivals.packet[order]]
    assert (np.diff(arrivals.left[order])[np.diff(at) == 0] > 0).all(), "one flit of a kind per cycle"
    flit = order - starts(given)[of]
    begins = np.append(True, np.diff(of) != 0)
    assert begins.sum() == len(given), "a packet's flits come one after the other"
    assert np.array_equal(flit == 0, begins)
    assert (np.diff(flit)[~begins[1:]] == 1).all()
    # Packets of the same nodes and kind, in the order in which they come out.
    packet = of[begins]
    pair = row[packet] * len(routing.port) + given.source[packet]
    together = np.argsort(pair, kind="stable")
    same = np.diff(pair[together]) == 0
    assert (np.diff(arrivals.entered[starts(given)[packet[together]]])[same] > 0).all(), "packets stay in order"


def run(name, flits, seed, load, share=1):
    """Every pattern of traffic on every shape, or on one of so many of them."""
    for number, routing in networks(name):
        messages = 1 + number % 2
        for index, pattern in enumerate(PATTERNS):
            if (number + index) % share:
                continue
            generator = np.random.default_rng([seed, number, index])
            topology = routing.topology
            given = packets(generator, topology, pattern, flits=flits, load=load, messages=messages)
            router_cycles = 1 + (number // 2 + index) % 2
            network = Network(routing, buffer_flits=(8, 1, 3)[number % 3], messages=messages,
                              arbitration=ARBITRATIONS[(number + index) % 2], router_cycles=router_cycles)
            arrivals = network.run(given, cycles=200 * flits, sink_stalls=stalls(generator, topology.nodes, 0.2),
                                   source_stalls=stalls(generator, topology.nodes, 0.1))
            check(routing, given, arrivals, messages, router_cycles)
            assert network.routers.sent == (1 + routing.hops[given.source, given.destination]) @ given.length
            assert network.routers.level.sum() == 0


@pytest.mark.parametrize("name", TOPOLOGIES)
def test_every_packet_arrives_once_whole_and_in_order(name):
    run(name, flits=150, seed=1, load=0.5, share=3)


@pytest.mark.nightly
@pytest.mark.parametrize("load", [0.1, 0.9])
@pytest.mark.parametrize("name", TOPOLOGIES)
def test_a_million_flits_arrive(name, load):
    run(name, flits=5000, seed=2, load=load)


@pytest.mark.parametrize("router_cycles", [1, 2])
def test_so_many_entries_sustain_a_flit_per_cycle(router_cycles):
    routing = route(Topology("mesh", 4, 1), 1)
    given = Packets(source=np.array([0]), destination=np.array([3]), length=np.array([100]), made=np.array([0]),
                    message=np.array([0]))
    cycles_by_entries = {}
    enough = router_cycles + 3
    for entries in enough - 1, enough:
        arrivals = Network(routing, buffer_flits=entries, router_cycles=router_cycles).run(given, cycles=1000)
        cycles_by_entries[entries] = arrivals.left[-1] - arrivals.left[0]
    assert cycles_by_entries[enough] == 99
    assert cycles_by_entries[enough - 1] > 99


def test_kinds_of_messages_have_channels_of_their_own():
    routing = route(Topology("mesh", 2, 2), 1)
    generator = np.random.default_rng(3)
    given = packets(generator, routing.topology, "uniform", flits=400, load=0.9, longest=3, messages=2)
    network = Network(routing, buffer_flits=2, messages=2)
    assert network.routers.channels == 2
    arrivals = network.run(given, cycles=20_000)
    check(routing, given, arrivals, 2)
    assert set(arrivals.channel[given.message[arrivals.packet] == 1]) == {1}


def test_copies_of_a_network_are_independent():
    routing = route(Topology("torus", 3, 3), 2)
    one = packets(np.random.default_rng(4), routing.topology, "uniform", flits=300, load=0.6)
    both = Packets(source=np.concatenate([one.source, one.source + 9]),
                   **{name: np.tile(getattr(one, name), 2) for name in ("destination", "length", "made", "message")})
    alone = Network(routing, buffer_flits=4).run(one, cycles=10_000)
    together = Network(routing, buffer_flits=4, copies=2).run(both, cycles=10_000)
    assert np.array_equal(together.left, np.tile(alone.left, 2))


@pytest.mark.parametrize("arbitration", ARBITRATIONS)
def test_queues_that_always_request_are_granted_in_turn(arbitration):
    """Both neighbours of a node send to it in every cycle; by age a queue is the youngest after its grant."""
    given = Packets(source=np.repeat([0, 2], 30), destination=np.ones(60, dtype=int), length=np.ones(60, dtype=int),
                    made=np.zeros(60, dtype=int), message=np.zeros(60, dtype=int))
    arrivals = Network(route(Topology("mesh", 3, 1), 1), buffer_flits=8, arbitration=arbitration).run(given, cycles=200)
    order = given.source[arrivals.packet[np.argsort(arrivals.left)]]
    assert np.abs(np.cumsum(order - 1)).max() <= 2


def test_age_precedes_round_robin_order():
    """Both arbitrations transfer the same flits, in another order."""
    routing = route(Topology("mesh", 4, 4), 1)
    given = packets(np.random.default_rng(5), routing.topology, "hotspot", flits=2000, load=0.7, longest=1)
    left = [Network(routing, buffer_flits=4, arbitration=name).run(given, cycles=10_000).left for name in ARBITRATIONS]
    assert (left[0] != left[1]).any()
    worst = [(times - given.made).max() for times in left]
    assert worst[1] < 2 * worst[0]


@pytest.mark.parametrize(("wrong", "message"), [
    ({"buffer_flits": 0}, "Buffer flits must be at least 1, not 0"), ({"messages": 0}, "Messages must be at least 1"),
    ({"router_cycles": 3}, "Router cycles must be 1 or 2, not 3"),
    ({"arbitration": "first"}, "Arbitration must be one of round-robin, age, not 'first'")])
def test_parameters_out_of_range_are_refused(wrong, message):
    with pytest.raises(InputError, match=message):
        Routers(route(Topology("mesh", 2, 1), 1), **{"buffer_flits": 2, **wrong})


def test_packets_to_nowhere_are_refused():
    nowhere = Packets(source=np.array([0]), destination=np.array([2]), length=np.array([1]), made=np.array([0]),
                      message=np.array([0]))
    with pytest.raises(InputError, match="Packets must have a source, a destination"):
        Network(route(Topology("mesh", 2, 1), 1), buffer_flits=2).run(nowhere, cycles=10)
