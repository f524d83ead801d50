"""Torus links: neighbours, the shortest routes of packets, and the loop of the state packet."""

from golden.base.compiled import compiled

__all__ = ["DOWN", "LEFT", "LINKS", "RIGHT", "UP", "has_box", "loop_link", "neighbour", "route_link"]

RIGHT, LEFT, UP, DOWN = range(4)
LINKS = 4
"""Links of a node; faces 0 to 3 of a box have the numbers of the links behind them."""


@compiled
def neighbour(node: int, link: int, side: int) -> int:
    """The node behind a link of a torus of side x side nodes, numbered in rows from the lower left."""
    row, column = node // side, node % side
    if link < UP:
        column = (column + (1 if link == RIGHT else side - 1)) % side
    else:
        row = (row + (1 if link == UP else side - 1)) % side
    return row * side + column


@compiled
def has_box(node: int, link: int, side: int) -> bool:
    """Whether space continues behind a link: links around the torus carry packets, but no rays."""
    row, column = node // side, node % side
    if link == RIGHT:
        return column < side - 1
    if link == LEFT:
        return column > 0
    return row < side - 1 if link == UP else row > 0


@compiled
def route_link(node: int, target: int, side: int, turn: int) -> int:
    """The link of a shortest route; the ``turn`` of a message selects among several.

    Source: Pearce 1987, section 3.6; figure 3-4, with the last row n - 1.
    """
    first = second = third = fourth = -1
    up, right = (target // side - node // side) % side, (target % side - node % side) % side
    if up and side - up >= up:
        first = UP
    if up and side - up <= up:
        second = DOWN
    if right and side - right >= right:
        third = RIGHT
    if right and side - right <= right:
        fourth = LEFT
    count = (first >= 0) + (second >= 0) + (third >= 0) + (fourth >= 0)
    left = turn % max(count, 1)
    for link in (first, second, third, fourth):
        if link >= 0:
            if left == 0:
                return link
            left -= 1
    return -1


@compiled
def loop_link(node: int, side: int) -> int:
    """The link of the loop over all nodes: rows are walked from their begin around to their end, then one row up.

    A row begins above the end of the row below, so that the last step is that from the top row around to node 0. The
    source has no loop.
    """
    return UP if node % side == (-(node // side) - 1) % side else RIGHT
