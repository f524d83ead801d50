"""The state packet begins a phase only when no node has work and no message travels: all interleavings are searched."""

import numpy as np
import pytest

from radiosity.machines.torus.columns import Node, Packet
from radiosity.machines.torus.state_packet import (
    CLIPPING,
    END,
    FLUSHPIX,
    RAYTRACE,
    enter_phase,
    receive_packet,
    release_packet,
)
from radiosity.machines.torus.torus_links import LINKS, loop_link, neighbour
from tb.radiosity.machines.torus.torus_cases import run_small

pytestmark = pytest.mark.usefixtures("interpreted")

receive, release, enter = (getattr(one, "py_func", one) for one in (receive_packet, release_packet, enter_phase))


class Search:
    """All states of nodes whose rays travel to any neighbour, over links of any delay.

    A state: phase, mark and packet of each node; the packet; the node to which it travels, or -1; rays of each node by
    hand-overs left; rays on links; primaries not yet begun.
    """

    def __init__(self, side, primaries, *, has_buffers=True, hops=1):
        self.side, self.nodes, self.hops, self.has_buffers = side, side * side, hops, has_buffers
        self.next = [neighbour(node, loop_link(node, side), side) for node in range(self.nodes)]
        self.near = [sorted({neighbour(node, link, side) for link in range(LINKS)} - {node})
                     for node in range(self.nodes)]
        self.first = (((CLIPPING, 0, 0),) * self.nodes, (CLIPPING, -1), 0, ((),) * self.nodes, (), primaries)

    def is_idle(self, state, node):
        nodes, _, _, queues, flying, primaries = state
        if queues[node] or (nodes[node][Node.PHASE] == RAYTRACE and primaries[node]):
            return False
        return not (self.has_buffers and any(source == node for source, _, _ in flying))

    def moves(self, state):
        nodes, packet, travels, queues, flying, primaries = state
        if travels >= 0:
            yield self.packet_arrives(state, travels)
        for node in range(self.nodes):
            if nodes[node][Node.HAS_PACKET] and self.is_idle(state, node):
                yield self.leaves(state, node, release)
            if nodes[node][Node.PHASE] != RAYTRACE:
                continue
            active = with_item(nodes, node, (nodes[node][Node.PHASE], 0, nodes[node][Node.HAS_PACKET]))
            if queues[node]:
                hops, rest = queues[node][0], with_item(queues, node, queues[node][1:])
                if not hops:
                    yield active, packet, travels, rest, flying, primaries
                else:
                    for other in self.near[node]:
                        yield (active, packet, travels, rest, tuple(sorted([*flying, (node, other, hops - 1)])),
                               primaries)
            elif primaries[node]:
                yield (active, packet, travels, with_item(queues, node, (self.hops,)), flying,
                       with_item(primaries, node, primaries[node] - 1))
        for message in sorted(set(flying)):
            _, node, hops = message
            rest = list(flying)
            rest.remove(message)
            array = np.array(nodes)
            enter(array, node, RAYTRACE)
            array[node, Node.IS_INACTIVE] = 0
            yield (as_tuples(array), packet, travels, with_item(queues, node, (hops, *queues[node])), tuple(rest),
                   primaries)

    def packet_arrives(self, state, node):
        def handle(packet, array, at):
            receive(packet, array, at, self.is_idle(state, at))
        return self.leaves(state, node, handle)

    def leaves(self, state, node, handle):
        """The packet is handled, and travels on unless it is kept."""
        nodes, packet, _, *rest = state
        array, numbers = np.array(nodes), np.array(packet)
        handle(numbers, array, node)
        travels = -1 if array[node, Node.HAS_PACKET] else self.next[node]
        return (as_tuples(array), tuple(numbers.tolist()), travels, *rest)

    def run(self):
        """States reached, those that begin flushing with rays left, and those without a move before the end."""
        seen, pending, early, stuck = {self.first}, [self.first], 0, 0
        while pending:
            state = pending.pop()
            nodes, packet, _, queues, flying, primaries = state
            if packet[Packet.STATE] >= FLUSHPIX and (any(queues) or flying or any(primaries)):
                early += 1
                continue
            if all(node[Node.PHASE] == END for node in nodes):
                continue
            found = [one for one in self.moves(state) if one not in seen]
            stuck += not any(True for _ in self.moves(state))
            seen.update(found)
            pending += found
        return len(seen), early, stuck


def with_item(items, at, value):
    return (*items[:at], value, *items[at + 1:])


def as_tuples(array):
    return tuple(tuple(row) for row in array.tolist())


@pytest.mark.parametrize(("side", "primaries", "hops", "least"), [
    (1, (2,), 0, 20), (2, (1, 0, 0, 0), 2, 300), (2, (0, 0, 0, 1), 2, 300), (2, (1, 0, 1, 0), 2, 3700),
    (2, (0, 1, 1, 1), 1, 2700)])
def test_no_interleaving_begins_a_phase_early_or_stops(side, primaries, hops, least):
    reached, early, stuck = Search(side, primaries, hops=hops).run()
    assert reached >= least
    assert (early, stuck) == (0, 0)


def test_it_would_be_early_if_nodes_with_messages_on_links_were_idle():
    """The negative control: the rule that buffers are empty is what forbids it."""
    _, early, _ = Search(2, (1, 0, 0, 0), hops=2, has_buffers=False).run()
    assert early > 0


def test_rays_on_every_link_keep_the_packet_from_its_next_phase():
    """Many laps pass while nothing arrives; then one more does not suffice, since each receiver is active."""
    search = Search(2, (0,) * 4)
    flying = tuple(sorted((node, other, 0) for node in range(4) for other in search.near[node]))
    state = (((RAYTRACE, 1, 0),) * 4, (RAYTRACE, 0), 0, ((),) * 4, flying, (0,) * 4)
    state = search.packet_arrives(state, 0)
    assert state[0][0][Node.HAS_PACKET]
    assert not search.is_idle(state, 0)
    # A node whose messages have all been taken passes it on; the next one keeps it in turn.
    for node in (0, 1, 3, 2):
        if state[2] >= 0:
            state = search.packet_arrives(state, state[2])
        assert state[0][node][Node.HAS_PACKET]
        state = (*state[:4], tuple(one for one in state[4] if one[0] != node), state[5])
        state = search.leaves(state, node, release)
        assert state[1] == (RAYTRACE, node)


def test_an_inactive_node_that_signed_last_raises_the_state_and_signs_again():
    nodes, packet = np.array([[RAYTRACE, 1, 0], [RAYTRACE, 1, 0]]), np.array([RAYTRACE, 1])
    receive_packet(packet, nodes, 0, True)
    assert packet.tolist() == [RAYTRACE, 1]
    receive_packet(packet, nodes, 1, True)
    assert packet.tolist() == [FLUSHPIX, 1]
    assert nodes[1].tolist() == [FLUSHPIX, 1, 0]
    receive_packet(packet, nodes, 0, True)
    assert packet.tolist() == [FLUSHPIX, 0]


def test_an_active_node_signs_keeps_the_packet_and_adopts_its_state():
    nodes, packet = np.array([[CLIPPING, 0, 0]]), np.array([RAYTRACE, 3])
    receive_packet(packet, nodes, 0, True)
    assert packet.tolist() == [RAYTRACE, 0]
    assert nodes[0].tolist() == [RAYTRACE, 1, 1]
    packet[Packet.LAST_BUSY] = 2
    release_packet(packet, nodes, 0)
    assert packet.tolist() == [RAYTRACE, 0]
    assert nodes[0].tolist() == [RAYTRACE, 1, 0]


def test_phases_are_entered_in_order():
    nodes = np.array([[FLUSHPIX, 0, 0]])
    enter_phase(nodes, 0, RAYTRACE)
    assert nodes[0, Node.PHASE] == FLUSHPIX
    enter_phase(nodes, 0, END)
    assert nodes[0, Node.PHASE] == END


@pytest.mark.parametrize("delay", [0, 50_000, 2_000_000])
def test_the_packet_makes_few_laps_whatever_the_delays(delay):
    run = run_small(nodes=9, delay=delay, seed=3)
    visits = run.state.visits[:, :3]
    assert (run.state.nodes[:, Node.PHASE] == END).all()
    assert visits.max() <= 6
    # Each phase takes one lap at least.
    assert visits[:, 1:].min() >= 1
