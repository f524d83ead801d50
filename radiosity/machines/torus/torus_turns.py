"""Torus turns: events in which a node takes its messages, handles the state packet, and traces one ray."""

from typing import NamedTuple

import numpy as np

from golden.base.compiled import compiled
from radiosity.machines.common.event_heap import EventHeap, next_time, pop, push
from radiosity.machines.torus import torus_state as ts
from radiosity.machines.torus.columns import Child, Count, Item, Link, Node, Packet, Ray, Tally
from radiosity.machines.torus.grid_walk import BLOCKED, EXIT, HIT, walk
from radiosity.machines.torus.node_grids import NodeGrids
from radiosity.machines.torus.ray_shading import Spawned, light_distance, shade
from radiosity.machines.torus.state_packet import (
    CLIPPING,
    END,
    FLUSHPIX,
    RAYTRACE,
    enter_phase,
    receive_packet,
    release_packet,
)
from radiosity.machines.torus.torus_links import LINKS, RIGHT, UP, has_box, loop_link, neighbour, route_link
from radiosity.machines.torus.torus_scene import Objects
from radiosity.machines.torus.torus_state import TorusState

__all__ = ["DONE", "EARLY", "FULL", "SCALE", "STUCK", "Machine", "run_turns", "start_turns"]

DONE, FULL, STUCK, EARLY = range(4)
"""How turns end: all nodes are at the end; there is no capacity for more items; no event waits; the state packet began
a phase while there was work."""

SCALE = 1 << 16
"""Units of a colour of 1 in the sums of pixels."""

_TURN, _SEND, _ARRIVE = range(3)
_MARGIN = 16


class Machine(NamedTuple):
    """All that stays.

    Parameters
    ----------
    side, size
        k; rows and columns of pixels.
    deepest, least
        Largest level of a ray, and the contribution below which none is made.
    has_shadows, steals
        Whether shadow rays are cast, and whether idle nodes request rows.
    buffer
        Bytes of a link's buffer.
    setup, walking, rest, call
        us: of a walk's setup; 5 int64: of each of its counts but the last; of the rest of a ray; of a call.
    slopes, front
        Tangents of half the fields of view along x and y, and z of the front.
    grids, objects, bounds
        Voxels and objects of the nodes, and N x 2 x 3 float64: the objects' bounds.
    grown
        P x 2 x 3 float64: the nodes' grown boxes.
    rows, columns
        k + 1 int64: pixels of each row and column of nodes.
    order
        Pixels in the order in which their nodes begin them.
    delays
        us by which messages are late, in turn.
    mail, walked, out
        Mailboxes, counts of a walk, children of a hit: overwritten.
    log
        W x 6 int64: of each walk its begin and us, node, pixel, level, and whether it is a shadow ray; as many as fit.
    """

    side: int
    size: tuple[int, int]
    deepest: int
    least: float
    has_shadows: bool
    steals: bool
    buffer: int
    setup: int
    walking: np.ndarray
    rest: int
    call: int
    slopes: tuple[float, float]
    front: float
    grids: NodeGrids
    objects: Objects
    bounds: np.ndarray
    grown: np.ndarray
    rows: np.ndarray
    columns: np.ndarray
    order: np.ndarray
    delays: np.ndarray
    mail: np.ndarray
    walked: np.ndarray
    out: Spawned
    log: np.ndarray


@compiled
def start_turns(heap: EventHeap, state: TorusState) -> None:
    """Node 0 creates the state packet, and a turn of each node is scheduled."""
    state.nodes[0, Node.HAS_PACKET] = 1
    for node in range(len(state.nodes)):
        state.nodes[node, Node.SLEEPS] = 0
        push(heap, 0, _TURN, node)


@compiled
def run_turns(heap: EventHeap, machine: Machine, state: TorusState) -> tuple[int, int]:
    """Turns until all nodes are at the end, or something is missing: how they end, and the time in us."""
    now = 0
    while next_time(heap) >= 0:
        if (state.counts[Count.FREE_ITEMS] < _MARGIN + len(machine.out.rays)
                or state.counts[Count.FREE_PACKETS] < _MARGIN):
            return FULL, now
        now, kind, subject = pop(heap)
        if kind == _TURN:
            if _turn(heap, machine, state, subject, now):
                return EARLY, now
            if state.counts[Count.ENDED] == len(state.nodes):
                return DONE, now
        elif kind == _SEND:
            _send(heap, machine, state, subject, now)
        else:
            state.links[subject, Link.ARRIVED] += 1
            node = neighbour(subject // LINKS, subject % LINKS, machine.side)
            if ts.wake_event(state, node):
                push(heap, now, _TURN, node)
    return STUCK, now


@compiled
def _turn(heap, machine, state, node, now):
    """Take all messages that have arrived, look at the state packet, and do one thing; then send what is to be sent.

    Whether the packet began a phase while there was work.
    """
    row, call, is_early = state.nodes[node], machine.call, False
    phase = row[Node.PHASE]
    cost, arrived = _poll(heap, machine, state, node, now)
    if arrived:
        state.visits[node, phase] += 1
        before = state.packet[Packet.STATE]
        receive_packet(state.packet, state.nodes, node, _is_idle(state, node))
        is_early = state.packet[Packet.STATE] != before and state.counts[Count.LIVE] > 0
        if not row[Node.HAS_PACKET]:
            _pass_packet(machine, state, node)
    if row[Node.PHASE] != phase and row[Node.PHASE] == END:
        state.counts[Count.ENDED] += 1
    phase, has_worked = row[Node.PHASE], _has_work(state, node)
    if has_worked:
        row[Node.IS_INACTIVE] = 0
        cost += _work(machine, state, node, now + cost)
    elif phase == RAYTRACE and machine.steals and _request(machine, state, node):
        row[Node.IS_INACTIVE] = 0
    elif row[Node.HAS_PACKET] and _is_idle(state, node):
        release_packet(state.packet, state.nodes, node)
        _pass_packet(machine, state, node)
    state.busy[node, phase] += cost
    if row[Node.OUT] != ts.NONE:
        push(heap, now + cost + call, _SEND, node)
    elif cost or has_worked or _has_work(state, node):
        push(heap, now + cost, _TURN, node)
    else:
        row[Node.SLEEPS] = 1
    return is_early


@compiled
def _pass_packet(machine, state, node):
    """The state packet is to go to the next node of its loop."""
    ts.put_out(state, node, loop_link(node, machine.side), ts.new_item(state, ts.TOKEN))


@compiled
def _has_work(state, node):
    """Whether a node has something to do in its phase."""
    row = state.nodes[node]
    if row[Node.PHASE] == CLIPPING:
        return row[Node.OBJECTS] != ts.NONE
    if row[Node.PHASE] == RAYTRACE:
        if row[Node.SHADOWS] != ts.NONE or row[Node.RAYS] != ts.NONE or row[Node.PRIMARY] < row[Node.PRIMARY_END]:
            return True
        is_given = False
        for link in range(LINKS):
            is_given |= state.grants[node, link, 1] < state.grants[node, link, 2]
        return is_given
    return row[Node.PHASE] == FLUSHPIX and state.packets[node, ts.VALUES_OF_PACKET, 0] > 0


@compiled
def _is_idle(state, node):
    """Whether a node has no work, and nothing in its buffers that a neighbour has not taken."""
    if state.nodes[node, Node.OUT] != ts.NONE or _has_work(state, node):
        return False
    used = 0
    for link in range(LINKS):
        used += state.links[LINKS * node + link, Link.USED]
    return used == 0


@compiled
def _poll(heap, machine, state, node, now):
    """Take what has arrived on all links: us, and whether the state packet was among it."""
    cost, side, arrived = 0, machine.side, False
    for link in range(LINKS):
        sender = neighbour(node, link, side)
        row = state.links[LINKS * sender + (link ^ 1)]
        while row[Link.ARRIVED]:
            item = row[Link.FIRST]
            row[Link.FIRST] = state.items[item, Item.NEXT]
            row[Link.ARRIVED] -= 1
            row[Link.USED] -= ts.message_bytes(state, item)
            if state.nodes[sender, Node.BLOCKED_LINK] == link ^ 1:
                state.nodes[sender, Node.BLOCKED_LINK] = ts.NONE
                push(heap, now, _SEND, sender)
            elif row[Link.USED] == 0 and state.nodes[sender, Node.HAS_PACKET] and ts.wake_event(state, sender):
                push(heap, now, _TURN, sender)
            cost += machine.call
            state.tallies[node, Tally.CALLS] += 1
            if state.items[item, Item.KIND] == ts.TOKEN:
                arrived = True
                ts.drop_item(state, item)
            else:
                state.nodes[node, Node.IS_INACTIVE] = 0
                cost += _take(machine, state, node, item)
    return cost, arrived


@compiled
def _take(machine, state, node, item):
    """A message but the state packet is at a node: us."""
    row = state.items[item]
    kind = row[Item.KIND]
    if kind == ts.RAY or kind == ts.SHADOW:
        # Only a node that traces rays sends one.
        enter_phase(state.nodes, node, RAYTRACE)
        ts.push_first(state, node, Node.SHADOWS if kind == ts.SHADOW else Node.RAYS, item)
    elif kind == ts.PIXELS:
        return _route_pixels(machine, state, node, item)
    elif kind == ts.OBJECT:
        ts.append(state, node, Node.OBJECTS, item)
    elif kind == ts.REQUEST:
        _give(machine, state, node, row[Item.TARGET])
        ts.drop_item(state, item)
    else:
        for column in range(3):
            state.grants[node, row[Item.VIA] ^ 1, column] = row[(Item.PIXEL, Item.COLUMN, Item.TARGET)[column]]
        if row[Item.COLUMN] < row[Item.TARGET]:
            state.nodes[node, Node.REQUESTED] &= ~(1 << (row[Item.VIA] ^ 1))
        ts.drop_item(state, item)
    return 0


@compiled
def _send(heap, machine, state, node, now):
    """The first message of a node goes to the buffer of its link, or the node blocks until it has enough free bytes."""
    call = machine.call
    item = state.nodes[node, Node.OUT]
    link = state.items[item, Item.VIA]
    row, size = state.links[LINKS * node + link], ts.message_bytes(state, item)
    if row[Link.USED] + size > machine.buffer:
        state.nodes[node, Node.BLOCKED_LINK] = link
        return
    ts.dequeue(state, node, Node.OUT)
    kind = state.items[item, Item.KIND]
    state.items[item, Item.NEXT] = ts.NONE
    if row[Link.USED] == 0:
        row[Link.FIRST] = item
    else:
        state.items[row[Link.LAST], Item.NEXT] = item
    row[Link.LAST] = item
    row[Link.USED] += size
    row[Link.MESSAGES] += 1
    state.tallies[node, Tally.PASSED] += kind == ts.RAY or kind == ts.SHADOW
    state.tallies[node, Tally.CALLS] += 1
    state.busy[node, state.nodes[node, Node.PHASE]] += call
    # Links do not overtake, however late their messages are.
    delay = machine.delays[state.counts[Count.SENT] % len(machine.delays)]
    state.counts[Count.SENT] += 1
    row[Link.LATEST] = max(row[Link.LATEST], now + delay)
    push(heap, row[Link.LATEST], _ARRIVE, LINKS * node + link)
    if state.nodes[node, Node.OUT] != ts.NONE:
        push(heap, now + call, _SEND, node)
    else:
        push(heap, now, _TURN, node)


@compiled
def _work(machine, state, node, now):
    """One thing of a phase: us."""
    row = state.nodes[node]
    if row[Node.PHASE] == CLIPPING:
        return _clip(machine, state, node)
    if row[Node.PHASE] == FLUSHPIX:
        return _send_pixels(machine, state, node)
    if row[Node.SHADOWS] != ts.NONE:
        return _trace(machine, state, node, ts.take_first(state, node, Node.SHADOWS), now)
    if row[Node.RAYS] == ts.NONE:
        pixel = _next_primary(machine, state, node)
        if pixel == ts.NONE:
            return 0
        _start_primary(machine, state, node, pixel)
    return _trace(machine, state, node, ts.take_first(state, node, Node.RAYS), now)


@compiled
def _clip(machine, state, node):
    """An object goes right along the lowest row and up from there, as far as boxes have it: us."""
    item, side = ts.dequeue(state, node, Node.OBJECTS), machine.side
    number = state.items[item, Item.PIXEL]
    state.tallies[node, Tally.DOWNLOADED] += 1
    for link in (RIGHT, UP):
        axis = 0 if link == RIGHT else 1
        if not has_box(node, link, side) or (link == RIGHT and node >= side):
            continue
        if machine.bounds[number, 1, axis] < machine.grown[neighbour(node, link, side), 0, axis]:
            continue
        if link == UP and (machine.bounds[number, 1, 0] < machine.grown[node, 0, 0]
                           or machine.bounds[number, 0, 0] > machine.grown[node, 1, 0]):
            continue
        passed = ts.new_item(state, ts.OBJECT)
        state.items[passed, Item.PIXEL] = number
        ts.put_out(state, node, link, passed)
    ts.drop_item(state, item)
    return machine.call if node == 0 else 0


@compiled
def _next_primary(machine, state, node):
    """The next pixel that has not begun, of the node's own, then of given rows; -1 without one."""
    row, columns = state.nodes[node], machine.size[1]
    while row[Node.PRIMARY] < row[Node.PRIMARY_END]:
        pixel = machine.order[row[Node.PRIMARY]]
        row[Node.PRIMARY] += 1
        if not state.is_started[pixel // columns, pixel % columns]:
            state.is_started[pixel // columns, pixel % columns] = True
            return pixel
    for link in range(LINKS):
        given = state.grants[node, link]
        if given[1] < given[2]:
            given[1] += 1
            return given[0] * columns + given[1] - 1
    return ts.NONE


@compiled
def _front_point(machine, pixel, axis):
    """Coordinate at which the primary ray of a pixel is at the front."""
    rows, columns = machine.size
    if axis == 0:
        return ((2 * (pixel % columns) + 1) / columns - 1) * (machine.slopes[0] * machine.front)
    return ((2 * (pixel // columns) + 1) / rows - 1) * (machine.slopes[1] * machine.front)


@compiled
def _start_primary(machine, state, node, pixel):
    """Make the primary ray of a pixel, from the eye on, which enters the grid at the front."""
    item = ts.new_item(state, ts.RAY)
    ray, row = state.rays[item], state.items[item]
    ray[Ray.DIRECTION], ray[Ray.DIRECTION + 1] = _front_point(machine, pixel, 0), _front_point(machine, pixel, 1)
    ray[Ray.DIRECTION + 2] = machine.front
    length = np.sqrt(ray[Ray.DIRECTION] * ray[Ray.DIRECTION] + ray[Ray.DIRECTION + 1] * ray[Ray.DIRECTION + 1]
                     + ray[Ray.DIRECTION + 2] * ray[Ray.DIRECTION + 2])
    for axis in range(3):
        ray[Ray.DIRECTION + axis] /= length
        ray[Ray.ORIGIN + axis], ray[Ray.COLOUR + axis], ray[Ray.CONTRIBUTION + axis] = 0.0, 0.0, 1.0
    ray[Ray.ENTRY], ray[Ray.LIMIT] = length, np.inf
    row[Item.PIXEL], row[Item.LEVEL], row[Item.MEDIUM] = pixel, 0, ts.NONE
    ts.push_first(state, node, Node.RAYS, item)
    state.tallies[node, Tally.PRIMARIES] += 1
    state.tallies[node, Tally.MADE] += 1


@compiled
def _trace(machine, state, node, item, now):
    """Walk a ray through the node, and do what follows: us."""
    ray, row, objects = state.rays[item], state.items[item], machine.objects
    origin, direction = ray[Ray.ORIGIN:Ray.ORIGIN + 3], ray[Ray.DIRECTION:Ray.DIRECTION + 3]
    walked = machine.walked
    walked[:] = 0
    state.counts[Count.WALKS] += 1
    ended, what, distance = walk(machine.grids, objects, node, origin, direction, ray[Ray.ENTRY], ray[Ray.LIMIT],
                                 machine.mail, state.counts[Count.WALKS], walked)
    cost = machine.setup
    for column in range(len(walked) - 1):
        cost += walked[column] * machine.walking[column]
    if row[Item.HOPS] == 0:
        cost += machine.rest
    state.tallies[node, Tally.TRACED] += 1
    for column in range(len(walked)):
        state.walked[node, column] += walked[column]
    logged = state.counts[Count.LOGGED]
    if logged < len(machine.log):
        entry = machine.log[logged]
        entry[0], entry[1], entry[2], entry[3] = now, cost, node, row[Item.PIXEL]
        entry[4], entry[5] = row[Item.LEVEL], row[Item.KIND] == ts.SHADOW
        state.counts[Count.LOGGED] += 1
    if ended == EXIT and what < LINKS and has_box(node, what, machine.side):
        ray[Ray.ENTRY] = distance
        row[Item.HOPS] += 1
        ts.put_out(state, node, what, item)
        return cost
    if row[Item.KIND] == ts.SHADOW:
        # A shadow ray that leaves space has no object before its light.
        if ended != BLOCKED:
            cost += _return_colour(machine, state, node, row[Item.PIXEL], ray[Ray.COLOUR:Ray.COLOUR + 3])
        ts.drop_item(state, item)
        return cost
    far = distance if ended == HIT else np.inf
    lit = ts.NONE
    for light in range(len(objects.lights)):
        to = light_distance(objects.lights, light, origin, direction)
        if to < far:
            lit, far = light, to
    if lit != ts.NONE:
        for channel in range(3):
            ray[Ray.COLOUR + channel] += ray[Ray.CONTRIBUTION + channel] * objects.lights[lit, 4 + channel]
    if lit != ts.NONE or ended != HIT:
        cost += _return_colour(machine, state, node, row[Item.PIXEL], ray[Ray.COLOUR:Ray.COLOUR + 3])
        ts.drop_item(state, item)
        return cost
    children = shade(objects, ray, row[Item.LEVEL], row[Item.MEDIUM], what, distance, machine.deepest,
                     machine.least, machine.has_shadows, machine.out)
    for number in range(children):
        is_shadow = machine.out.numbers[number, Child.IS_SHADOW]
        child = ts.new_item(state, ts.SHADOW if is_shadow else ts.RAY)
        for column in range(state.rays.shape[1]):
            state.rays[child, column] = machine.out.rays[number, column]
        state.items[child, Item.PIXEL] = row[Item.PIXEL]
        state.items[child, Item.LEVEL] = machine.out.numbers[number, Child.LEVEL]
        state.items[child, Item.MEDIUM] = machine.out.numbers[number, Child.MEDIUM]
        ts.push_first(state, node, Node.SHADOWS if is_shadow else Node.RAYS, child)
        state.tallies[node, Tally.MADE] += 1
        state.tallies[node, Tally.SHADOWS_MADE] += is_shadow
    cost += _return_colour(machine, state, node, row[Item.PIXEL], machine.out.colour)
    ts.drop_item(state, item)
    return cost


@compiled
def _return_colour(machine, state, node, pixel, colour):
    """A value that is not black goes to the node's packet of pixels, which goes to node 0 when it is full: us."""
    packet = state.packets[node]
    count = packet[ts.VALUES_OF_PACKET, 0]
    is_black = True
    for channel in range(3):
        packet[count, 1 + channel] = int(np.floor(colour[channel] * SCALE + 0.5))
        is_black &= packet[count, 1 + channel] == 0
    if is_black:
        return 0
    packet[count, 0] = pixel
    packet[ts.VALUES_OF_PACKET, 0] += 1
    state.tallies[node, Tally.VALUES] += 1
    return _send_pixels(machine, state, node) if count + 1 == ts.VALUES_OF_PACKET else 0


@compiled
def _send_pixels(machine, state, node):
    """The node's packet of pixels goes to node 0: us."""
    state.counts[Count.FREE_PACKETS] -= 1
    number = state.free_packets[state.counts[Count.FREE_PACKETS]]
    for value in range(ts.VALUES_OF_PACKET + 1):
        for column in range(4):
            state.packets[number, value, column] = state.packets[node, value, column]
    state.packets[node, ts.VALUES_OF_PACKET, 0] = 0
    state.tallies[node, Tally.PACKETS] += 1
    item = ts.new_item(state, ts.PIXELS)
    state.items[item, Item.PIXEL] = number
    return _route_pixels(machine, state, node, item)


@compiled
def _route_pixels(machine, state, node, item):
    """A packet of pixels goes on towards node 0, which gives it to the host with a call: us."""
    if node:
        ts.put_out(state, node, route_link(node, 0, machine.side, state.turns[node]), item)
        state.turns[node] += 1
        return 0
    number, columns = state.items[item, Item.PIXEL], machine.size[1]
    for value in range(state.packets[number, ts.VALUES_OF_PACKET, 0]):
        pixel = state.packets[number, value, 0]
        for channel in range(3):
            state.picture[pixel // columns, pixel % columns, channel] += state.packets[number, value, 1 + channel]
    state.free_packets[state.counts[Count.FREE_PACKETS]] = number
    state.counts[Count.FREE_PACKETS] += 1
    ts.drop_item(state, item)
    state.tallies[0, Tally.CALLS] += 1
    return machine.call


@compiled
def _request(machine, state, node):
    """An idle node requests rows from each neighbour in space, once until one gives some: whether it does now."""
    side, is_new = machine.side, False
    for link in range(LINKS):
        if has_box(node, link, side) and not state.nodes[node, Node.REQUESTED] >> link & 1:
            state.nodes[node, Node.REQUESTED] |= 1 << link
            item = ts.new_item(state, ts.REQUEST)
            state.items[item, Item.TARGET] = link ^ 1
            ts.put_out(state, node, link, item)
            is_new = True
    return is_new


@compiled
def _give(machine, state, node, link):
    """Reply to a neighbour with a row of pixels of which none has begun and which enter its box, or with none."""
    side = machine.side
    requester = neighbour(node, link, side)
    item = ts.new_item(state, ts.GRANT)
    row = state.items[item]
    bottom, top = machine.rows[node // side], machine.rows[node // side + 1]
    left, right = machine.columns[node % side], machine.columns[node % side + 1]
    for step in range(top - bottom):
        # The neighbour above has the upper rows in its box.
        pixels = top - 1 - step if link == UP else bottom + step
        first, end, is_free = right, left, True
        for column in range(left, right):
            pixel, is_inside = pixels * machine.size[1] + column, True
            for axis in range(2):
                at = _front_point(machine, pixel, axis)
                is_inside &= machine.grown[requester, 0, axis] < at < machine.grown[requester, 1, axis]
            if is_inside:
                first, end = min(first, column), column + 1
                is_free &= not state.is_started[pixels, column]
        if first < end and is_free:
            for column in range(first, end):
                state.is_started[pixels, column] = True
            row[Item.PIXEL], row[Item.COLUMN], row[Item.TARGET] = pixels, first, end
            state.tallies[node, Tally.GIVEN] += 1
            break
    ts.put_out(state, node, link, item)
