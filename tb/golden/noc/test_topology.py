"""Hop counts against closed forms."""

import numpy as np
import pytest

from golden.errors import InputError
from golden.noc.topology import TOPOLOGIES, grid_shape, hops, links

SIZES = [1, 2, 4, 8, 16, 32]


def places(processors):
    columns, _ = grid_shape(processors)
    number = np.arange(processors)
    return number % columns, number // columns


def around(first, second, size):
    apart = np.abs(first[:, None] - second[None])
    return np.minimum(apart, size - apart)


@pytest.mark.parametrize("processors", SIZES)
def test_mesh_torus_ring_and_hypercube_have_the_distances_of_their_definitions(processors):
    (column, row), (columns, rows) = places(processors), grid_shape(processors)
    number = np.arange(processors)
    mesh = np.abs(column[:, None] - column) + np.abs(row[:, None] - row)
    assert np.array_equal(hops("mesh", processors), mesh)
    assert np.array_equal(hops("torus", processors), around(column, column, columns) + around(row, row, rows))
    assert np.array_equal(hops("ring", processors), around(number, number, processors))
    assert np.array_equal(hops("hypercube", processors), np.bitwise_count(number[:, None] ^ number))


def test_illiac_of_sixteen_reaches_everything_in_three_links():
    distance = hops("illiac", 16)
    assert np.flatnonzero(distance[0] == 1).tolist() == [1, 4, 12, 15]
    assert distance.max() == 3


def test_illiac_of_eight_is_no_longer_than_a_ring():
    assert (hops("illiac", 8) <= hops("ring", 8)).all()
    assert links("illiac", 8).sum(axis=1).tolist() == [3] * 8


@pytest.mark.parametrize("topology", TOPOLOGIES)
@pytest.mark.parametrize("processors", SIZES)
def test_links_go_both_ways_and_to_others_only(topology, processors):
    linked = links(topology, processors)
    assert np.array_equal(linked, linked.T)
    assert not linked.diagonal().any()
    assert np.array_equal(linked, hops(topology, processors) == 1)


def test_grids_are_square_or_twice_as_wide():
    assert [grid_shape(size) for size in SIZES] == [(1, 1), (2, 1), (2, 2), (4, 2), (4, 4), (8, 4)]


def test_other_topologies_and_sizes_are_refused_by_name():
    with pytest.raises(InputError, match=r"Topology must be one of mesh, torus, .*, not 'star'"):
        links("star", 4)
    for size in 0, 3, -4, 2.0, True:
        with pytest.raises(InputError, match="Processors must be a power of two"):
            hops("ring", size)
