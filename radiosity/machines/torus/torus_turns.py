"""Torus turns: events in which a node takes its messages, handles the state packet, and traces one ray."""

from typing import NamedTuple

import numpy as np

from golden.base.compiled import compiled
from radiosity.machines.common.event_heap import EventHeap, next_time, pop, push
from radiosity.machines.torus import torus_state as ts
from radiosity.machines.torus.grid_walk import BLOCKED, EXIT, HIT, WALK_COUNTS, walk
from radiosity.machines.torus.node_grids import NodeGrids
from radiosity.machines.torus.ray_shading import (
    COLOUR,
    CONTRIBUTION,
    DIRECTION,
    ENTRY,
    IS_SHADOW,
    LEVEL,
    LIMIT,
    MEDIUM,
    ORIGIN,
    RAY_COLUMNS,
    Spawned,
    light_distance,
    shade,
)
from radiosity.machines.torus.state_packet import (
    CLIPPING,
    END,
    FLUSHPIX,
    HAS_PACKET,
    IS_INACTIVE,
    PHASE,
    RAYTRACE,
    STATE,
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
# Of ``ints``: rows and columns of nodes and pixels, the deepest level, switches, bytes of a link's buffer, and times.
(SIDE, ROWS, COLUMNS, DEEPEST, HAS_SHADOWS, STEALS, BUFFER, SETUP, STEP, _SPHERE_TEST, _POLYGON_TEST, _SPHERE_HIT,
 _POLYGON_HIT, REST, CALL) = range(15)
# Of ``floats``: least contribution, tangents of half the fields of view, z of the front.
LEAST, SLOPE_X, SLOPE_Y, FRONT = range(4)
_MARGIN = 16


class Machine(NamedTuple):
    """All that stays.

    Parameters
    ----------
    ints, floats
        15 int64 and 4 float64, see the numbers.
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

    ints: np.ndarray
    floats: np.ndarray
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
def start_turns(heap: EventHeap, machine: Machine, state: TorusState) -> None:
    """Node 0 creates the state packet, and a turn of each node is scheduled."""
    state.nodes[0, HAS_PACKET] = 1
    for node in range(len(state.nodes)):
        state.nodes[node, ts.SLEEPS] = 0
        push(heap, 0, _TURN, node)


@compiled
def run_turns(heap: EventHeap, machine: Machine, state: TorusState) -> tuple[int, int]:
    """Turns until all nodes are at the end, or something is missing: how they end, and the time in us."""
    now = 0
    while next_time(heap) >= 0:
        if state.counts[ts.FREE_ITEMS] < _MARGIN + len(machine.out.rays) or state.counts[ts.FREE_PACKETS] < _MARGIN:
            return FULL, now
        now, kind, subject = pop(heap)
        if kind == _TURN:
            if _turn(heap, machine, state, subject, now):
                return EARLY, now
            if state.counts[ts.ENDED] == len(state.nodes):
                return DONE, now
        elif kind == _SEND:
            _send(heap, machine, state, subject, now)
        else:
            state.links[subject, ts.ARRIVED] += 1
            node = neighbour(subject // LINKS, subject % LINKS, machine.ints[SIDE])
            if ts.wake_event(state, node):
                push(heap, now, _TURN, node)
    return STUCK, now


@compiled
def _turn(heap, machine, state, node, now):
    """Take all messages that have arrived, look at the state packet, and do one thing; then send what is to be sent.

    Whether the packet began a phase while there was work.
    """
    row, call, is_early = state.nodes[node], machine.ints[CALL], False
    phase = row[PHASE]
    cost, arrived = _poll(heap, machine, state, node, now)
    if arrived:
        state.tallies[node, ts.VISITS + phase] += 1
        before = state.packet[STATE]
        receive_packet(state.packet, state.nodes, node, _is_idle(state, node))
        is_early = state.packet[STATE] != before and state.counts[ts.LIVE] > 0
        if not row[HAS_PACKET]:
            _pass_packet(machine, state, node)
    if row[PHASE] != phase and row[PHASE] == END:
        state.counts[ts.ENDED] += 1
    phase, has_worked = row[PHASE], _has_work(state, node)
    if has_worked:
        row[IS_INACTIVE] = 0
        cost += _work(machine, state, node, now + cost)
    elif phase == RAYTRACE and machine.ints[STEALS] and _request(machine, state, node):
        row[IS_INACTIVE] = 0
    elif row[HAS_PACKET] and _is_idle(state, node):
        release_packet(state.packet, state.nodes, node)
        _pass_packet(machine, state, node)
    state.tallies[node, ts.BUSY + phase] += cost
    if row[ts.OUT] != ts.NONE:
        push(heap, now + cost + call, _SEND, node)
    elif cost or has_worked or _has_work(state, node):
        push(heap, now + cost, _TURN, node)
    else:
        row[ts.SLEEPS] = 1
    return is_early


@compiled
def _pass_packet(machine, state, node):
    """The state packet is to go to the next node of its loop."""
    ts.put_out(state, node, loop_link(node, machine.ints[SIDE]), ts.new_item(state, ts.TOKEN))


@compiled
def _has_work(state, node):
    """Whether a node has something to do in its phase."""
    row = state.nodes[node]
    if row[PHASE] == CLIPPING:
        return row[ts.OBJECTS] != ts.NONE
    if row[PHASE] == RAYTRACE:
        if row[ts.SHADOWS] != ts.NONE or row[ts.RAYS] != ts.NONE or row[ts.PRIMARY] < row[ts.PRIMARY_END]:
            return True
        is_given = False
        for link in range(LINKS):
            is_given |= state.grants[node, link, 1] < state.grants[node, link, 2]
        return is_given
    return row[PHASE] == FLUSHPIX and state.packets[node, ts.VALUES_OF_PACKET, 0] > 0


@compiled
def _is_idle(state, node):
    """Whether a node has no work, and nothing in its buffers that a neighbour has not taken."""
    if state.nodes[node, ts.OUT] != ts.NONE or _has_work(state, node):
        return False
    used = 0
    for link in range(LINKS):
        used += state.links[LINKS * node + link, ts.USED]
    return used == 0


@compiled
def _poll(heap, machine, state, node, now):
    """Take what has arrived on all links: us, and whether the state packet was among it."""
    cost, side, arrived = 0, machine.ints[SIDE], False
    for link in range(LINKS):
        sender = neighbour(node, link, side)
        row = state.links[LINKS * sender + (link ^ 1)]
        while row[ts.ARRIVED]:
            item = row[ts.FIRST]
            row[ts.FIRST] = state.items[item, ts.NEXT_ITEM]
            row[ts.ARRIVED] -= 1
            row[ts.USED] -= ts.message_bytes(state, item)
            if state.nodes[sender, ts.BLOCKED_LINK] == link ^ 1:
                state.nodes[sender, ts.BLOCKED_LINK] = ts.NONE
                push(heap, now, _SEND, sender)
            elif row[ts.USED] == 0 and state.nodes[sender, HAS_PACKET] and ts.wake_event(state, sender):
                push(heap, now, _TURN, sender)
            cost += machine.ints[CALL]
            state.tallies[node, ts.CALLS] += 1
            if state.items[item, ts.KIND] == ts.TOKEN:
                arrived = True
                ts.drop_item(state, item)
            else:
                state.nodes[node, IS_INACTIVE] = 0
                cost += _take(machine, state, node, item)
    return cost, arrived


@compiled
def _take(machine, state, node, item):
    """A message but the state packet is at a node: us."""
    row = state.items[item]
    kind = row[ts.KIND]
    if kind == ts.RAY or kind == ts.SHADOW:
        # Only a node that traces rays sends one.
        enter_phase(state.nodes, node, RAYTRACE)
        ts.push_first(state, node, ts.SHADOWS if kind == ts.SHADOW else ts.RAYS, item)
    elif kind == ts.PIXELS:
        return _route_pixels(machine, state, node, item)
    elif kind == ts.OBJECT:
        ts.append(state, node, ts.OBJECTS, item)
    elif kind == ts.REQUEST:
        _give(machine, state, node, row[ts.TARGET])
        ts.drop_item(state, item)
    else:
        for column in range(3):
            state.grants[node, row[ts.VIA] ^ 1, column] = row[(ts.PIXEL, ts.COLUMN, ts.TARGET)[column]]
        if row[ts.COLUMN] < row[ts.TARGET]:
            state.nodes[node, ts.REQUESTED] &= ~(1 << (row[ts.VIA] ^ 1))
        ts.drop_item(state, item)
    return 0


@compiled
def _send(heap, machine, state, node, now):
    """The first message of a node goes to the buffer of its link, or the node blocks until it has enough free bytes."""
    call = machine.ints[CALL]
    item = state.nodes[node, ts.OUT]
    link = state.items[item, ts.VIA]
    row, size = state.links[LINKS * node + link], ts.message_bytes(state, item)
    if row[ts.USED] + size > machine.ints[BUFFER]:
        state.nodes[node, ts.BLOCKED_LINK] = link
        return
    ts.dequeue(state, node, ts.OUT)
    kind = state.items[item, ts.KIND]
    state.items[item, ts.NEXT_ITEM] = ts.NONE
    if row[ts.USED] == 0:
        row[ts.FIRST] = item
    else:
        state.items[row[ts.LAST], ts.NEXT_ITEM] = item
    row[ts.LAST] = item
    row[ts.USED] += size
    row[ts.LINK_MESSAGES] += 1
    state.tallies[node, ts.PASSED] += kind == ts.RAY or kind == ts.SHADOW
    state.tallies[node, ts.CALLS] += 1
    state.tallies[node, ts.BUSY + state.nodes[node, PHASE]] += call
    # Links do not overtake, however late their messages are.
    delay = machine.delays[state.counts[ts.SENT] % len(machine.delays)]
    state.counts[ts.SENT] += 1
    row[ts.LATEST] = max(row[ts.LATEST], now + delay)
    push(heap, row[ts.LATEST], _ARRIVE, LINKS * node + link)
    if state.nodes[node, ts.OUT] != ts.NONE:
        push(heap, now + call, _SEND, node)
    else:
        push(heap, now, _TURN, node)


@compiled
def _work(machine, state, node, now):
    """One thing of a phase: us."""
    row = state.nodes[node]
    if row[PHASE] == CLIPPING:
        return _clip(machine, state, node)
    if row[PHASE] == FLUSHPIX:
        return _send_pixels(machine, state, node)
    if row[ts.SHADOWS] != ts.NONE:
        return _trace(machine, state, node, ts.take_first(state, node, ts.SHADOWS), now)
    if row[ts.RAYS] == ts.NONE:
        pixel = _next_primary(machine, state, node)
        if pixel == ts.NONE:
            return 0
        _start_primary(machine, state, node, pixel)
    return _trace(machine, state, node, ts.take_first(state, node, ts.RAYS), now)


@compiled
def _clip(machine, state, node):
    """An object goes right along the lowest row and up from there, as far as boxes have it: us."""
    item, side = ts.dequeue(state, node, ts.OBJECTS), machine.ints[SIDE]
    number = state.items[item, ts.PIXEL]
    state.tallies[node, ts.DOWNLOADED] += 1
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
        state.items[passed, ts.PIXEL] = number
        ts.put_out(state, node, link, passed)
    ts.drop_item(state, item)
    return machine.ints[CALL] if node == 0 else 0


@compiled
def _next_primary(machine, state, node):
    """The next pixel that has not begun, of the node's own, then of given rows; -1 without one."""
    row, columns = state.nodes[node], machine.ints[COLUMNS]
    while row[ts.PRIMARY] < row[ts.PRIMARY_END]:
        pixel = machine.order[row[ts.PRIMARY]]
        row[ts.PRIMARY] += 1
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
    if axis == 0:
        return ((2 * (pixel % machine.ints[COLUMNS]) + 1) / machine.ints[COLUMNS] - 1) * (
            machine.floats[SLOPE_X] * machine.floats[FRONT])
    return ((2 * (pixel // machine.ints[COLUMNS]) + 1) / machine.ints[ROWS] - 1) * (
        machine.floats[SLOPE_Y] * machine.floats[FRONT])


@compiled
def _start_primary(machine, state, node, pixel):
    """Make the primary ray of a pixel, from the eye on, which enters the grid at the front."""
    item = ts.new_item(state, ts.RAY)
    ray, row = state.rays[item], state.items[item]
    ray[DIRECTION], ray[DIRECTION + 1] = _front_point(machine, pixel, 0), _front_point(machine, pixel, 1)
    ray[DIRECTION + 2] = machine.floats[FRONT]
    length = np.sqrt(ray[DIRECTION] * ray[DIRECTION] + ray[DIRECTION + 1] * ray[DIRECTION + 1]
                     + ray[DIRECTION + 2] * ray[DIRECTION + 2])
    for axis in range(3):
        ray[DIRECTION + axis] /= length
        ray[ORIGIN + axis], ray[COLOUR + axis], ray[CONTRIBUTION + axis] = 0.0, 0.0, 1.0
    ray[ENTRY], ray[LIMIT] = length, np.inf
    row[ts.PIXEL], row[ts.LEVEL_OF], row[ts.MEDIUM_OF] = pixel, 0, ts.NONE
    ts.push_first(state, node, ts.RAYS, item)
    state.tallies[node, ts.PRIMARIES] += 1
    state.tallies[node, ts.MADE] += 1


@compiled
def _trace(machine, state, node, item, now):
    """Walk a ray through the node, and do what follows: us."""
    ray, row, ints, objects = state.rays[item], state.items[item], machine.ints, machine.objects
    walked = machine.walked
    walked[:] = 0
    state.counts[ts.WALKS] += 1
    ended, what, distance = walk(machine.grids, objects, node, ray[ORIGIN:ORIGIN + 3], ray[DIRECTION:DIRECTION + 3],
                                 ray[ENTRY], ray[LIMIT], machine.mail, state.counts[ts.WALKS], walked)
    cost = ints[SETUP]
    for column in range(WALK_COUNTS - 1):
        cost += walked[column] * ints[STEP + column]
    if row[ts.HOPS] == 0:
        cost += ints[REST]
    state.tallies[node, ts.TRACED] += 1
    for column in range(WALK_COUNTS):
        state.tallies[node, ts.WALKED + column] += walked[column]
    logged = state.counts[ts.LOGGED]
    if logged < len(machine.log):
        entry = machine.log[logged]
        entry[0], entry[1], entry[2], entry[3] = now, cost, node, row[ts.PIXEL]
        entry[4], entry[5] = row[ts.LEVEL_OF], row[ts.KIND] == ts.SHADOW
        state.counts[ts.LOGGED] += 1
    if ended == EXIT and what < LINKS and has_box(node, what, ints[SIDE]):
        ray[ENTRY] = distance
        row[ts.HOPS] += 1
        ts.put_out(state, node, what, item)
        return cost
    if row[ts.KIND] == ts.SHADOW:
        # A shadow ray that leaves space has no object before its light.
        if ended != BLOCKED:
            cost += _return_colour(machine, state, node, row[ts.PIXEL], ray[COLOUR:COLOUR + 3])
        ts.drop_item(state, item)
        return cost
    far = distance if ended == HIT else np.inf
    lit = ts.NONE
    for light in range(len(objects.lights)):
        to = light_distance(objects.lights, light, ray[ORIGIN:ORIGIN + 3], ray[DIRECTION:DIRECTION + 3])
        if to < far:
            lit, far = light, to
    if lit != ts.NONE:
        for channel in range(3):
            ray[COLOUR + channel] += ray[CONTRIBUTION + channel] * objects.lights[lit, 4 + channel]
    if lit != ts.NONE or ended != HIT:
        cost += _return_colour(machine, state, node, row[ts.PIXEL], ray[COLOUR:COLOUR + 3])
        ts.drop_item(state, item)
        return cost
    children = shade(objects, ray, row[ts.LEVEL_OF], row[ts.MEDIUM_OF], what, distance, ints[DEEPEST],
                     machine.floats[LEAST], ints[HAS_SHADOWS] != 0, machine.out)
    for number in range(children):
        is_shadow = machine.out.numbers[number, IS_SHADOW]
        child = ts.new_item(state, ts.SHADOW if is_shadow else ts.RAY)
        for column in range(RAY_COLUMNS):
            state.rays[child, column] = machine.out.rays[number, column]
        state.items[child, ts.PIXEL] = row[ts.PIXEL]
        state.items[child, ts.LEVEL_OF] = machine.out.numbers[number, LEVEL]
        state.items[child, ts.MEDIUM_OF] = machine.out.numbers[number, MEDIUM]
        ts.push_first(state, node, ts.SHADOWS if is_shadow else ts.RAYS, child)
        state.tallies[node, ts.MADE] += 1
        state.tallies[node, ts.SHADOWS_MADE] += is_shadow
    cost += _return_colour(machine, state, node, row[ts.PIXEL], machine.out.colour)
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
    state.tallies[node, ts.VALUES] += 1
    return _send_pixels(machine, state, node) if count + 1 == ts.VALUES_OF_PACKET else 0


@compiled
def _send_pixels(machine, state, node):
    """The node's packet of pixels goes to node 0: us."""
    state.counts[ts.FREE_PACKETS] -= 1
    number = state.free_packets[state.counts[ts.FREE_PACKETS]]
    for value in range(ts.VALUES_OF_PACKET + 1):
        for column in range(4):
            state.packets[number, value, column] = state.packets[node, value, column]
    state.packets[node, ts.VALUES_OF_PACKET, 0] = 0
    state.tallies[node, ts.PACKETS] += 1
    item = ts.new_item(state, ts.PIXELS)
    state.items[item, ts.PIXEL] = number
    return _route_pixels(machine, state, node, item)


@compiled
def _route_pixels(machine, state, node, item):
    """A packet of pixels goes on towards node 0, which gives it to the host with a call: us."""
    if node:
        ts.put_out(state, node, route_link(node, 0, machine.ints[SIDE], state.turns[node]), item)
        state.turns[node] += 1
        return 0
    number, columns = state.items[item, ts.PIXEL], machine.ints[COLUMNS]
    for value in range(state.packets[number, ts.VALUES_OF_PACKET, 0]):
        pixel = state.packets[number, value, 0]
        for channel in range(3):
            state.picture[pixel // columns, pixel % columns, channel] += state.packets[number, value, 1 + channel]
    state.free_packets[state.counts[ts.FREE_PACKETS]] = number
    state.counts[ts.FREE_PACKETS] += 1
    ts.drop_item(state, item)
    state.tallies[0, ts.CALLS] += 1
    return machine.ints[CALL]


@compiled
def _request(machine, state, node):
    """An idle node requests rows from each neighbour in space, once until one gives some: whether it does now."""
    side, is_new = machine.ints[SIDE], False
    for link in range(LINKS):
        if has_box(node, link, side) and not state.nodes[node, ts.REQUESTED] >> link & 1:
            state.nodes[node, ts.REQUESTED] |= 1 << link
            item = ts.new_item(state, ts.REQUEST)
            state.items[item, ts.TARGET] = link ^ 1
            ts.put_out(state, node, link, item)
            is_new = True
    return is_new


@compiled
def _give(machine, state, node, link):
    """Reply to a neighbour with a row of pixels of which none has begun and which enter its box, or with none."""
    side = machine.ints[SIDE]
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
            pixel, is_inside = pixels * machine.ints[COLUMNS] + column, True
            for axis in range(2):
                at = _front_point(machine, pixel, axis)
                is_inside &= machine.grown[requester, 0, axis] < at < machine.grown[requester, 1, axis]
            if is_inside:
                first, end = min(first, column), column + 1
                is_free &= not state.is_started[pixels, column]
        if first < end and is_free:
            for column in range(first, end):
                state.is_started[pixels, column] = True
            row[ts.PIXEL], row[ts.COLUMN], row[ts.TARGET] = pixels, first, end
            state.tallies[node, ts.GIVEN] += 1
            break
    ts.put_out(state, node, link, item)
