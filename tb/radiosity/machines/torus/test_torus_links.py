"""Shortest routes around the torus, alternately, and the loop of the state packet."""

import numpy as np
import pytest

from radiosity.machines.torus.columns import Link
from radiosity.machines.torus.torus_links import (
    DOWN,
    LEFT,
    LINKS,
    RIGHT,
    UP,
    has_box,
    loop_link,
    neighbour,
    route_link,
)
from tb.radiosity.machines.torus.torus_cases import run_small

pytestmark = pytest.mark.usefixtures("interpreted")


def distance(node, target, side):
    row, column = abs(node // side - target // side), abs(node % side - target % side)
    return min(row, side - row) + min(column, side - column)


@pytest.mark.parametrize("side", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("turn", [0, 1, 2, 3])
def test_each_hop_is_on_a_shortest_route(side, turn):
    for node in range(side * side):
        for target in range(side * side):
            link = route_link(node, target, side, turn)
            if node == target:
                assert link == -1
            else:
                assert distance(neighbour(node, link, side), target, side) == distance(node, target, side) - 1


def test_several_shortest_routes_alternate():
    assert [route_link(0, 5, 4, turn) for turn in range(4)] == [UP, RIGHT, UP, RIGHT]
    assert [route_link(0, 8, 4, turn) for turn in range(4)] == [UP, DOWN, UP, DOWN]
    assert {route_link(0, 10, 4, turn) for turn in range(4)} == {UP, DOWN, RIGHT, LEFT}
    assert [route_link(0, 1, 4, turn) for turn in range(3)] == [RIGHT] * 3


def test_packets_alternate_in_the_machine():
    run = run_small(nodes=4, size=(40, 40), growth=1.0)
    links = run.state.links[:, Link.MESSAGES].reshape(4, LINKS)
    # From the upper right node packets go down, up, left and right in turn.
    assert run.state.turns[3] >= 8
    assert (links[3] >= run.state.turns[3] // 4).all()


@pytest.mark.parametrize("side", [1, 2, 3, 4, 7])
def test_the_loop_visits_every_node_once_and_returns(side):
    node, seen = 0, []
    for _ in range(side * side):
        seen.append(node)
        node = neighbour(node, loop_link(node, side), side)
    assert sorted(seen) == list(range(side * side))
    assert node == 0


def test_links_are_two_way_and_space_ends_at_the_border():
    for side in (2, 3):
        for node in range(side * side):
            for link in range(LINKS):
                assert neighbour(neighbour(node, link, side), link ^ 1, side) == node
    inside = np.array([[has_box(node, link, 3) for link in (RIGHT, LEFT, UP, DOWN)] for node in range(9)])
    assert inside.sum() == 24
    assert inside[4].all()
    assert inside[0].tolist() == [True, False, True, False]
