"""Patches are dealt before rows are made: in turn, shuffled or in tiles, with new numbers in the nodes' order."""

import numpy as np
import pytest

from golden.base.errors import InputError
from radiosity.machines.common.assignment import ASSIGNMENTS, assign, of_rows, shares

pytestmark = pytest.mark.usefixtures("interpreted")


@pytest.mark.parametrize("kind", ASSIGNMENTS)
@pytest.mark.parametrize("patches", [16, 19, 31])
def test_the_first_nodes_have_one_patch_more(kind, patches):
    found = assign(kind, patches, 8, seed=3)
    assert found.sizes.tolist() == [patches // 8 + (node < patches % 8) for node in range(8)]
    assert np.array_equal(np.sort(found.order), np.arange(patches))


def test_scattered_patches_are_dealt_in_turn():
    assert assign("scattered", 10, 4).order.tolist() == [0, 4, 8, 1, 5, 9, 2, 6, 3, 7]


def test_tiles_are_neighbours():
    assert assign("tiled", 10, 4).order.tolist() == list(range(10))


def test_random_patches_are_dealt_in_turn_after_a_shuffle():
    found = assign("random", 12, 4, seed=5)
    shuffled = np.random.default_rng(5).permutation(12)
    assert [found.patches(node).tolist() for node in range(4)] == [shuffled[node::4].tolist() for node in range(4)]
    assert not np.array_equal(found.order, assign("random", 12, 4, seed=6).order)


def test_new_numbers_of_a_node_are_consecutive():
    found = of_rows([[4, 1], [], [0, 3, 2]])
    assert found.number.tolist() == [2, 1, 4, 3, 0]
    assert np.array_equal(found.order[found.number], np.arange(5))
    assert found.patches(2).tolist() == [0, 3, 2]
    assert found.nodes == 3


def test_shares_differ_by_one():
    assert shares(11, 4).tolist() == [3, 3, 3, 2]


@pytest.mark.parametrize(("kind", "patches", "nodes", "message"), [
    ("even", 16, 4, "Assignment must be one of random, scattered, tiled, not 'even'"),
    ("tiled", 16, 3, "Nodes must be a power of two up to 1024, not 3"),
    ("tiled", 16, 0, "Nodes must be a power of two up to 1024, not 0"),
    ("tiled", 4096, 2048, "Nodes must be a power of two up to 1024, not 2048"),
    ("tiled", 3, 4, "Nodes must be at most the 3 patches, not 4")])
def test_wrong_assignments_are_refused(kind, patches, nodes, message):
    with pytest.raises(InputError, match=message):
        assign(kind, patches, nodes)


def test_patches_are_whole():
    with pytest.raises(TypeError, match=r"Patches must be an int, not 4\.0"):
        assign("tiled", 4.0, 2)
