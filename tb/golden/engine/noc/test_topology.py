"""Links and hop counts against closed forms."""

import numpy as np
import pytest

from golden.base.errors import InputError
from golden.engine.noc.topology import LOCAL, NOWHERE, TOPOLOGIES, Topology, grid_shape

SIZES = [1, 2, 3, 4, 6, 8, 12, 16, 32, 49]
# A hypercube has a power of two nodes.
NETWORKS = [(topology, nodes) for topology in TOPOLOGIES for nodes in SIZES
            if topology != "hypercube" or nodes & (nodes - 1) == 0]


def around(first, second, size):
    apart = np.abs(first[:, None] - second[None])
    return np.minimum(apart, size - apart)


@pytest.mark.parametrize("nodes", SIZES)
def test_mesh_torus_ring_and_hypercube_have_the_distances_of_their_definitions(nodes):
    columns, rows = grid_shape(nodes)
    number = np.arange(nodes)
    column, row = number % columns, number // columns
    mesh = np.abs(column[:, None] - column) + np.abs(row[:, None] - row)
    assert np.array_equal(Topology.of("mesh", nodes).hops, mesh)
    assert np.array_equal(Topology.of("torus", nodes).hops, around(column, column, columns) + around(row, row, rows))
    assert np.array_equal(Topology.of("ring", nodes).hops, around(number, number, nodes))
    if nodes & (nodes - 1) == 0:
        assert np.array_equal(Topology.of("hypercube", nodes).hops, np.bitwise_count(number[:, None] ^ number))


def test_illiac_of_sixteen_reaches_everything_in_three_links():
    distance = Topology.of("illiac", 16).hops
    assert np.flatnonzero(distance[0] == 1).tolist() == [1, 4, 12, 15]
    assert distance.max() == 3


def test_illiac_of_eight_is_no_longer_than_a_ring():
    assert (Topology.of("illiac", 8).hops <= Topology.of("ring", 8).hops).all()
    assert ((Topology.of("illiac", 8).neighbour != NOWHERE).sum(axis=1) == 3).all()


@pytest.mark.parametrize("topology", TOPOLOGIES)
def test_every_link_returns_through_the_same_ports(topology):
    for nodes in (nodes for name, nodes in NETWORKS if name == topology):
        assert_links_return(Topology.of(topology, nodes))


def assert_links_return(network):
    links = {(link.source, link.output, link.target, link.input) for link in network.links}
    assert len(links) == len(network.links) == (network.neighbour != NOWHERE).sum()
    assert {(target, inward, source, outward) for source, outward, target, inward in links} == links
    assert all(source != target and LOCAL not in (outward, inward) for source, outward, target, inward in links)
    # No two links lead from one node to the same other one.
    assert len({(link.source, link.target) for link in network.links}) == len(links)


@pytest.mark.parametrize(("topology", "columns", "rows", "ports"), [
    ("mesh", 4, 3, ["local", "east", "west", "south", "north"]), ("mesh", 1, 3, ["local", "south", "north"]),
    ("torus", 3, 1, ["local", "east", "west"]), ("ring", 4, 4, ["local", "east", "west"]),
    ("illiac", 1, 5, ["local", "east", "west"]), ("illiac", 3, 3, ["local", "east", "west", "south", "north"]),
    ("hypercube", 4, 2, ["local", "bit_0", "bit_1", "bit_2"]), ("mesh", 1, 1, ["local"])])
def test_ports_are_those_of_the_dimensions_there_are(topology, columns, rows, ports):
    assert list(Topology(topology, columns, rows).ports) == ports


def test_nodes_are_numbered_row_by_row():
    mesh = Topology("mesh", 4, 3)
    assert mesh.coordinates[6].tolist() == [2, 1]
    assert mesh.neighbour[6].tolist() == [NOWHERE, 7, 5, 10, 2]
    assert mesh.neighbour[3].tolist() == [NOWHERE, NOWHERE, 2, 7, NOWHERE]
    assert mesh.opposite == (LOCAL, 2, 1, 4, 3)
    assert Topology("torus", 4, 3).neighbour[3].tolist() == [NOWHERE, 0, 2, 7, 11]
    assert Topology("illiac", 4, 3).neighbour[3].tolist() == [NOWHERE, 4, 2, 7, 11]


def test_grids_are_as_square_as_they_can_be():
    assert [grid_shape(size) for size in (1, 2, 4, 6, 7, 8, 12, 16, 32)] == [
        (1, 1), (2, 1), (2, 2), (3, 2), (7, 1), (4, 2), (4, 3), (4, 4), (8, 4)]


def test_other_topologies_and_sizes_are_refused_by_name():
    with pytest.raises(InputError, match=r"Topology must be one of mesh, torus, .*, not 'star'"):
        Topology.of("star", 4)
    for size in 0, -4:
        with pytest.raises(InputError, match=f"Nodes must be at least 1, not {size}"):
            Topology.of("ring", size)
        with pytest.raises(InputError, match=f"Rows must be at least 1, not {size}"):
            Topology("mesh", 2, size)
    for size in 2.0, True, "4":
        with pytest.raises(TypeError, match=f"Nodes must be an int, not {size!r}"):
            Topology.of("ring", size)
        with pytest.raises(TypeError, match=f"Rows must be an int, not {size!r}"):
            Topology("mesh", 2, size)
    with pytest.raises(InputError, match="Nodes of a hypercube must be a power of two, not 12"):
        Topology("hypercube", 4, 3)
