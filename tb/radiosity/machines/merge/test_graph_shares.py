"""The graph of a mesh is bisected: sides are balanced, and few edges are cut."""

from itertools import pairwise

import numpy as np
import pytest

from radiosity.machines.merge.graph_shares import graph_shares

pytestmark = pytest.mark.usefixtures("interpreted")


def cut_of(owner, edges):
    across = owner[:, :-1] != owner[:, 1:]
    down = owner[:-1] != owner[1:]
    return edges[0, :, :-1][across].sum() + edges[1, :-1][down].sum()


def drawn(seed, mesh=32):
    rng = np.random.default_rng(seed)
    return rng.random((mesh, mesh)), rng.random((2, mesh, mesh))


@pytest.mark.parametrize("seed", range(2))
def test_sides_are_balanced_and_cut_less_than_straight_lines(seed):
    loads, edges = drawn(seed)
    levels = graph_shares(loads, edges, 2)
    assert [len(np.unique(owner)) for owner in levels] == [1, 2, 4]
    sums = np.bincount(levels[1].ravel(), loads.ravel())
    assert sums.max() <= 0.51 * loads.sum() + loads.max()
    straight = np.repeat(np.arange(2), 16)[:, None] + np.zeros((1, 32), dtype=np.int64)
    assert cut_of(levels[1], edges) < 1.1 * cut_of(straight, edges)


def test_a_cheap_cut_is_found():
    """Two halves that hang together by light edges, along a winding line."""
    loads, edges = np.ones((32, 32)), np.ones((2, 32, 32))
    side = np.add.outer(np.arange(32), 5 * np.sin(np.arange(32) / 4)) > 16
    edges[0, :, :-1][side[:, :-1] != side[:, 1:]] = 0.01
    edges[1, :-1][side[:-1] != side[1:]] = 0.01
    owner = graph_shares(loads, edges, 1)[1]
    assert cut_of(owner, edges) < 3
    assert abs((owner == side).mean() - 0.5) > 0.4


def test_each_level_divides_the_parts_of_the_one_before():
    loads, edges = drawn(9)
    levels = graph_shares(loads, edges, 4)
    for before, after in pairwise(levels):
        assert np.array_equal(after // 2, before)
    sums = np.bincount(levels[4].ravel(), loads.ravel(), 16)
    assert sums.max() < 1.2 * sums.mean()


def test_cells_without_loads_have_owners():
    assert len(graph_shares(np.zeros((4, 4)), np.zeros((2, 4, 4)), 2)) == 3
