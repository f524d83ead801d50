"""Routes are shortest, and no network has a cycle of channel dependencies."""


import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.sparse.csgraph import connected_components

from golden.base.errors import InputError
from golden.engine.noc.routing import (
    Routing,
    check_deadlock_free,
    classes_needed,
    dependency_graph,
    route,
)
from golden.engine.noc.topology import LOCAL, TOPOLOGIES, Topology

ALL = [(name, columns, rows) for name in TOPOLOGIES for columns in range(1, 9) for rows in range(1, 9)
       if name != "hypercube" or columns * rows & (columns * rows - 1) == 0]


def is_acyclic(graph):
    """Each vertex reaches none that reaches it, itself included."""
    numbers = {vertex: number for number, vertex in enumerate(graph)}
    edges = np.array([(numbers[held], numbers[vertex]) for vertex, before in graph.items() for held in before],
                     dtype=int).reshape(-1, 2)
    matrix = csr_array((np.ones(len(edges)), edges.T), shape=(len(graph), len(graph)))
    count, _ = connected_components(matrix, connection="strong")
    return count == len(graph) and (edges[:, 0] != edges[:, 1]).all()


def check(topology, virtual_channels):
    routing = route(topology, virtual_channels)
    assert np.array_equal(routing.hops, topology.hops)
    graph = dependency_graph(topology, routing.port, routing.channel)
    assert is_acyclic(graph)
    used = {(link.source, link.output) for link in topology.links}
    assert {vertex[:2] for vertex in graph} == used
    assert routing.channel.min() >= 0
    assert max(routing.channel.max(), routing.entry.max()) < virtual_channels
    assert (routing.port.diagonal() == LOCAL).all()
    assert (routing.channel.diagonal() == 0).all()


@pytest.mark.nightly
@pytest.mark.parametrize(("name", "columns", "rows"), ALL)
def test_none_up_to_eight_by_eight_can(name, columns, rows):
    topology = Topology(name, columns, rows)
    for factor in range(1, 5):
        check(topology, factor * classes_needed(topology))


@pytest.mark.parametrize(("name", "nodes", "classes"), [
    ("mesh", 64, 1), ("hypercube", 64, 1), ("torus", 9, 1), ("torus", 16, 2), ("ring", 3, 1), ("ring", 8, 2),
    ("illiac", 16, 2), ("illiac", 64, 2)])
def test_long_rings_need_two_classes(name, nodes, classes):
    assert classes_needed(Topology.of(name, nodes)) == classes


@pytest.mark.parametrize(("name", "columns", "rows"), [("torus", 4, 4), ("torus", 8, 8), ("ring", 8, 1),
                                                       ("illiac", 4, 4)])
def test_a_ring_with_one_channel_is_refused_with_the_cycle(name, columns, rows):
    topology = Topology(name, columns, rows)
    with pytest.raises(InputError, match="with Virtual channels 1 can deadlock: ") as refused:
        route(topology, 1)
    cycle = str(refused.value).partition("deadlock: ")[2].split(" -> ")
    assert cycle[0] == cycle[-1]
    nodes, ports = zip(*(step.split()[:2] for step in cycle), strict=True)
    for node, port, after in zip(nodes, ports, nodes[1:], strict=False):
        assert topology.neighbour[int(node), topology.ports.index(port)] == int(after)
    route(topology, 2)


@pytest.mark.parametrize(("virtual_channels", "error", "message"), [
    (0, InputError, "at least 1, not 0"), (-1, InputError, "at least 1, not -1"), (2.0, TypeError, "an int, not 2.0"),
    (True, TypeError, "an int, not True")])
def test_channels_are_a_number(virtual_channels, error, message):
    with pytest.raises(error, match=f"Virtual channels must be {message}"):
        route(Topology("mesh", 2, 2), virtual_channels)


def test_channels_are_a_multiple_of_the_classes():
    with pytest.raises(InputError, match="Virtual channels of a torus 4 x 4 must be a multiple of 2, not 3"):
        route(Topology("torus", 4, 4), 3)


def mesh_with(port):
    topology = Topology("mesh", 2, 2)
    return Routing(topology=topology, virtual_channels=1, port=np.array(port), channel=np.zeros((4, 4), dtype=int),
                   entry=np.zeros((4, 4), dtype=int))


def test_a_cyclic_routing_is_refused():
    # Clockwise around a square (0 1 / 2 3): to the node opposite over the next one.
    east, west, south, north = 1, 2, 3, 4
    with pytest.raises(InputError, match=r"mesh 2 x 2 with Virtual channels 1 can deadlock: 0 east channel 0 -> 1 "
                                         r"south channel 0 -> 3 west channel 0 -> 2 north channel 0 -> 0 east"):
        check_deadlock_free(mesh_with([[0, east, south, east], [west, 0, south, south], [north, north, 0, east],
                                       [west, north, west, 0]]))


def test_a_routing_that_keeps_a_packet_is_refused():
    east, west, south, north = 1, 2, 3, 4
    xy = [[0, east, south, east], [west, 0, west, south], [north, east, 0, east], [west, north, west, 0]]
    check_deadlock_free(mesh_with(xy))
    for wrong in LOCAL, north, west:
        lost = [row[:] for row in xy]
        lost[1][3] = wrong
        with pytest.raises(InputError, match=r"mesh 2 x 2: packets from \d to 3 do not arrive"):
            check_deadlock_free(mesh_with(lost))


@pytest.mark.parametrize("virtual_channels", [2, 4])
def test_channels_share_uniform_traffic_in_the_order_of_the_next_port(virtual_channels):
    routing = route(Topology("mesh", 8, 8), virtual_channels)
    passing = np.zeros((64, 64), dtype=int)
    for source in range(64):
        for destination in range(64):
            for node, _, _ in routing.path(source, destination):
                passing[node, destination] += 1
    for link in routing.topology.links:
        to = np.flatnonzero(routing.port[link.source] == link.output)
        needed, channel = routing.port[link.target, to], routing.channel[link.source, to]
        order = np.lexsort((to, needed))
        assert (np.diff(channel[order]) >= 0).all()
        load = np.bincount(channel, weights=passing[link.source, to], minlength=virtual_channels)
        # A destination is not divided.
        assert np.ptp(load) <= 2 * passing[link.source, to].max()
