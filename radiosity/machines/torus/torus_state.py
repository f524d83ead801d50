"""Torus state: nodes, queues, links and messages of the machine in flat arrays."""

from typing import NamedTuple

import numpy as np

from golden.base.compiled import compiled
from radiosity.machines.torus.columns import Count, Item, Link, Node, Ray, Tally, Walk
from radiosity.machines.torus.state_packet import CLIPPING, PHASES
from radiosity.machines.torus.torus_links import LINKS

__all__ = ["TorusState", "append", "dequeue", "drop_item", "enlarged", "message_bytes", "new_item", "push_first",
           "put_out", "take_first", "torus_state", "wake_event"]

NONE = -1

RAY, SHADOW, PIXELS, TOKEN, OBJECT, REQUEST, GRANT = range(7)
"""Kinds of messages."""

VALUES_OF_PACKET = 21
"""Values of a full packet of pixels; the row behind them begins with their number."""

# Bytes of words of 4 bytes: a ray as the source lists it, with its entry; a shadow ray; a header and a value of pixels.
_RAY_BYTES, _SHADOW_BYTES, _HEADER_BYTES, _VALUE_BYTES = 60, 48, 4, 16
# The state packet, an object of four corners, a request, a grant.
_TOKEN_BYTES, _OBJECT_BYTES, _REQUEST_BYTES, _GRANT_BYTES = 8, 140, 4, 16


class TorusState(NamedTuple):
    """All that changes, which compiled functions do.

    Parameters
    ----------
    nodes
        P rows of int64, see `Node`.
    grants
        P x 4 x 3 int64: row, next column and end of the pixels that each neighbour has given.
    links
        4 P rows of int64, see `Link`; link 4 n + l leaves node n.
    turns
        P int64: packets that each node has sent towards node 0.
    items, rays
        Q rows of int64 and of float64, see `Item` and `Ray`: rays and messages.
    free
        Q int64: numbers of items that are free.
    packets, free_packets
        S x 22 x 4 int64: pixel and colour of values. Packet n of the first P is that which node n fills; the others
        travel. Numbers of those that are free.
    is_started
        R x C bool: the pixel's primary ray has begun or been given.
    picture
        R x C x 3 int64: sums of values.
    packet
        2 int64, see `Packet`: the state packet.
    tallies, visits, busy, walked
        P rows of int64: see `Tally`; visits of the packet and busy us by phase; counts of walks, see `Walk`.
    counts
        int64 by `Count`.
    """

    nodes: np.ndarray
    grants: np.ndarray
    links: np.ndarray
    turns: np.ndarray
    items: np.ndarray
    rays: np.ndarray
    free: np.ndarray
    packets: np.ndarray
    free_packets: np.ndarray
    is_started: np.ndarray
    picture: np.ndarray
    packet: np.ndarray
    tallies: np.ndarray
    visits: np.ndarray
    busy: np.ndarray
    walked: np.ndarray
    counts: np.ndarray


@compiled
def message_bytes(state: TorusState, item: int) -> int:
    """Bytes of a message in a link's buffer."""
    kind = state.items[item, Item.KIND]
    if kind == RAY:
        return _RAY_BYTES
    if kind == SHADOW:
        return _SHADOW_BYTES
    if kind == PIXELS:
        return _HEADER_BYTES + _VALUE_BYTES * state.packets[state.items[item, Item.PIXEL], VALUES_OF_PACKET, 0]
    if kind == TOKEN:
        return _TOKEN_BYTES
    if kind == OBJECT:
        return _OBJECT_BYTES
    return _REQUEST_BYTES if kind == REQUEST else _GRANT_BYTES


@compiled
def new_item(state: TorusState, kind: int) -> int:
    """A new ray or message."""
    state.counts[Count.FREE_ITEMS] -= 1
    item = state.free[state.counts[Count.FREE_ITEMS]]
    for column in range(state.items.shape[1]):
        state.items[item, column] = 0
    state.items[item, Item.NEXT], state.items[item, Item.KIND] = NONE, kind
    state.counts[Count.LIVE] += kind != TOKEN
    return item


@compiled
def drop_item(state: TorusState, item: int) -> None:
    """A ray or message ends."""
    state.counts[Count.LIVE] -= state.items[item, Item.KIND] != TOKEN
    state.free[state.counts[Count.FREE_ITEMS]] = item
    state.counts[Count.FREE_ITEMS] += 1


@compiled
def push_first(state: TorusState, node: int, queue: int, item: int) -> None:
    """A ray is the next one of a node's queue."""
    state.items[item, Item.NEXT] = state.nodes[node, queue]
    state.nodes[node, queue] = item
    state.nodes[node, Node.HELD] += 1
    state.tallies[node, Tally.MOST_HELD] = max(state.tallies[node, Tally.MOST_HELD], state.nodes[node, Node.HELD])


@compiled
def take_first(state: TorusState, node: int, queue: int) -> int:
    """The next ray leaves a node's queue."""
    item = state.nodes[node, queue]
    state.nodes[node, queue] = state.items[item, Item.NEXT]
    state.nodes[node, Node.HELD] -= 1
    return item


@compiled
def append(state: TorusState, node: int, queue: int, item: int) -> None:
    """An item is the last one of a node's queue of objects or of messages."""
    row = state.nodes[node]
    state.items[item, Item.NEXT] = NONE
    if row[queue] == NONE:
        row[queue] = item
    else:
        state.items[row[queue + 1], Item.NEXT] = item
    row[queue + 1] = item


@compiled
def dequeue(state: TorusState, node: int, queue: int) -> int:
    """The first item of such a queue leaves it."""
    item = state.nodes[node, queue]
    state.nodes[node, queue] = state.items[item, Item.NEXT]
    return item


@compiled
def put_out(state: TorusState, node: int, link: int, item: int) -> None:
    """A node is to send a message on a link, after those before it."""
    state.items[item, Item.VIA] = link
    append(state, node, Node.OUT, item)


@compiled
def wake_event(state: TorusState, node: int) -> bool:
    """Whether a node slept, so that a turn of it is to be scheduled."""
    if state.nodes[node, Node.SLEEPS]:
        state.nodes[node, Node.SLEEPS] = 0
        return True
    return False


def torus_state(side: int, size: tuple[int, int], bounds: np.ndarray, *, items: int = 1 << 12) -> TorusState:
    """The state before the first turn: all nodes sleep in the phase of clipping.

    Parameters
    ----------
    side
        k.
    size
        Rows and columns of pixels.
    bounds
        P + 1 int64: where the primary rays of each node begin in their order, and their number.
    items
        Capacity for rays and messages.
    """
    count = side * side
    nodes = np.zeros((count, len(Node)), dtype=np.int64)
    nodes[:, [Node.RAYS, Node.SHADOWS, Node.OBJECTS, Node.OUT, Node.BLOCKED_LINK]] = NONE
    nodes[:, Node.PHASE], nodes[:, Node.SLEEPS] = CLIPPING, 1
    nodes[:, Node.PRIMARY], nodes[:, Node.PRIMARY_END] = bounds[:-1], bounds[1:]
    links = np.zeros((LINKS * count, len(Link)), dtype=np.int64)
    links[:, [Link.FIRST, Link.LAST]] = NONE
    packets = 2 * count + 64
    counts = np.zeros(len(Count), dtype=np.int64)
    counts[Count.FREE_ITEMS], counts[Count.FREE_PACKETS] = items, packets - count
    return TorusState(
        nodes=nodes, grants=np.zeros((count, LINKS, 3), dtype=np.int64), links=links,
        turns=np.zeros(count, dtype=np.int64), items=np.zeros((items, len(Item)), dtype=np.int64),
        rays=np.zeros((items, Ray.END)), free=np.arange(items),
        packets=np.zeros((packets, VALUES_OF_PACKET + 1, 4), dtype=np.int64),
        free_packets=np.append(np.arange(count, packets), np.zeros(count, dtype=np.int64)),
        is_started=np.zeros(size, dtype=np.bool_), picture=np.zeros((*size, 3), dtype=np.int64),
        packet=np.array([CLIPPING, NONE], dtype=np.int64), counts=counts,
        **{name: np.zeros((count, columns), dtype=np.int64) for name, columns in (
            ("tallies", len(Tally)), ("visits", len(PHASES)), ("busy", len(PHASES)), ("walked", len(Walk)))})


def enlarged(state: TorusState) -> TorusState:
    """The same state with twice the capacity for items and packets, all numbers kept."""
    counts = state.counts
    items, packets = len(state.items), len(state.packets)

    def twice(array):
        return np.concatenate([array, np.zeros_like(array)])

    free, free_packets = twice(state.free), twice(state.free_packets)
    free[counts[Count.FREE_ITEMS]:counts[Count.FREE_ITEMS] + items] = np.arange(items, 2 * items)
    free_packets[counts[Count.FREE_PACKETS]:counts[Count.FREE_PACKETS] + packets] = np.arange(packets, 2 * packets)
    counts[Count.FREE_ITEMS] += items
    counts[Count.FREE_PACKETS] += packets
    return state._replace(items=twice(state.items), rays=twice(state.rays), free=free, packets=twice(state.packets),
                          free_packets=free_packets)
