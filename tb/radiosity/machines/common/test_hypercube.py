"""Messages take the links of their routes; rings are embedded with neighbours one hop apart."""

import numpy as np
import pytest

from radiosity.machines.common.hypercube import MESSAGES, WORDS, hypercube, ring, transfer
from radiosity.machines.common.node_timing import NodeTiming

pytestmark = pytest.mark.usefixtures("interpreted")

TIMING = NodeTiming(setup=100, word=10)


@pytest.mark.parametrize("nodes", [2, 4, 16, 1024])
def test_neighbours_of_the_ring_are_neighbours_of_the_hypercube(nodes):
    around = ring(nodes)
    assert np.array_equal(np.sort(around), np.arange(nodes))
    assert (np.bitwise_count(around ^ np.roll(around, 1)) == 1).all()


def test_a_far_node_is_as_near_as_a_neighbour():
    for target in (1, 15):
        assert transfer(hypercube(16, TIMING), 50, 0, target, 7) == 50 + 7 * 10


def test_a_message_waits_for_each_link_of_its_route():
    cube = hypercube(8, TIMING)
    assert transfer(cube, 0, 1, 3, 5) == 50
    # From 0 to 7 by 1 and 3; from 5 to 4 by another link; from 3 to 1 in the other direction.
    assert transfer(cube, 20, 0, 7, 2) == 50 + 20
    assert transfer(cube, 20, 5, 4, 2) == 40
    assert transfer(cube, 20, 3, 1, 2) == 40
    assert transfer(cube, 60, 1, 3, 1) == 70 + 10


def test_the_host_has_one_link_to_node_0():
    cube = hypercube(4, TIMING)
    assert transfer(cube, 0, 2, 4, 3) == 30
    assert transfer(cube, 10, 1, 4, 3) == 30 + 30
    assert transfer(cube, 10, 4, 3, 3) == 40
    assert transfer(cube, 15, 4, 1, 1) == 50


def test_messages_and_words_are_counted_at_their_source():
    cube = hypercube(4, TIMING)
    for words in (3, 4):
        transfer(cube, 0, 2, 1, words)
    assert cube.sent[2, [MESSAGES, WORDS]].tolist() == [2, 7]
    assert cube.sent.sum() == 9
