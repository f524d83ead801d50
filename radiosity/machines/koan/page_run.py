"""Page run: nodes that work on items, refer to pages, and request items from each other along a ring."""

from typing import NamedTuple

import numpy as np

from golden.base.compiled import compiled
from radiosity.machines.common.event_heap import next_time, pop, push
from radiosity.machines.common.hypercube import ring
from radiosity.machines.koan.page_protocol import ITEM, RING, RUN, fault, handle, refer, send, serving
from radiosity.machines.koan.page_state import NONE, WRITE, Count, Node, PageState, References

__all__ = ["ItemTimes", "Items", "run_items"]

# Of a message that has an item, or the origin of a request.
_WORDS = 2


class Items(NamedTuple):
    """I items of work, in the order in which nodes have them.

    Parameters
    ----------
    first
        I + 1 int64: the first reference of each item, and R.
    work
        I int64: ns of each item without faults, in equal shares before its references.
    check
        I int64: ns of each reference of an item to a page of another home, which the program itself looks for.
    own
        N + 1 int64: the first item of each node, and I.
    """

    first: np.ndarray
    work: np.ndarray
    check: np.ndarray
    own: np.ndarray


class ItemTimes(NamedTuple):
    """What has become of the items.

    Parameters
    ----------
    node, begins, ends
        I int64: who worked on each, and its ns.
    stops
        N int64: when each node knew that no item was left.
    """

    node: np.ndarray
    begins: np.ndarray
    ends: np.ndarray
    stops: np.ndarray


def run_items(state: PageState, items: Items, references: References, start: np.ndarray, *,
              is_shared: bool) -> ItemTimes:
    """Work on all items.

    A node works on its own items in their order. Then, if items are shared, it sends a request to its successor on a
    ring that a Gray code makes; a node without an item that has not begun forwards it. Who gets its own request back
    stops. An item is taken from the end of its owner's, where the owner comes last; the source does not say which.
    Requests are handled at interrupt level, for the set-up of what is sent.

    Parameters
    ----------
    state
        Pages, links and counts; it changes.
    items, references
        The work; ``value`` of references that load is set.
    start
        N int64: when each node begins.
    is_shared
        Whether nodes request items from each other.

    Source: Badouel 1991, section 4.2.
    """
    count, nodes = len(items.work), len(state.nodes)
    around = ring(nodes)
    successor = np.empty(nodes, dtype=np.int64)
    successor[around] = np.roll(around, -1)
    times = ItemTimes(node=np.full(count, -1), begins=np.zeros(count, dtype=np.int64),
                      ends=np.zeros(count, dtype=np.int64), stops=np.array(start, dtype=np.int64))
    _run(state, items, references, times, successor, is_shared and nodes > 1, not (references.pages & 1).any())
    return times


@compiled
def _run(state, items, references, times, successor, is_shared, is_read_only):
    """All events."""
    for node in range(len(state.nodes)):
        state.nodes[node, Node.OWN], state.nodes[node, Node.END] = items.own[node], items.own[node + 1]
        _next_item(state, items, times, successor, node, times.stops[node], is_shared)
    while next_time(state.heap) >= 0:
        time, kind, subject = pop(state.heap)
        if kind == RUN:
            if state.nodes[subject, Node.STOLEN]:
                push(state.heap, time + state.nodes[subject, Node.STOLEN], RUN, subject)
                state.nodes[subject, Node.STOLEN] = 0
            else:
                _advance(state, items, references, times, successor, subject, time, is_shared, is_read_only)
        elif kind in (RING, ITEM):
            _passed(state, items, times, successor, time, kind, subject)
        else:
            handle(state, references, time, kind, subject)


@compiled
def _begin(state, items, times, node, item, time):
    """A node begins an item."""
    state.nodes[node, Node.CURRENT] = item
    state.nodes[node, Node.REFERENCE] = state.nodes[node, Node.WORKED] = items.first[item]
    state.nodes[node, Node.RUNS] = True
    times.node[item], times.begins[item] = node, time
    push(state.heap, time, RUN, node)


@compiled
def _next_item(state, items, times, successor, node, time, is_shared):
    """A node begins its next own item, or requests another's, or stops."""
    first = state.nodes[node, Node.OWN]
    if first < state.nodes[node, Node.END]:
        state.nodes[node, Node.OWN] += 1
        _begin(state, items, times, node, first, time)
        return
    state.nodes[node, Node.CURRENT] = -1
    state.nodes[node, Node.RUNS] = False
    times.stops[node] = time
    if is_shared:
        state.counts[node, Count.RING_REQUESTS] += 1
        state.counts[node, Count.RING_HOPS] += 1
        send(state, time, node, successor[node], _WORDS, RING, node, 0)


@compiled
def _passed(state, items, times, successor, time, kind, subject):
    """A request or an item has arrived; a request is answered, forwarded, or returned."""
    nodes = len(state.nodes)
    node, about = subject // 2 % nodes, subject // 2 // nodes // nodes
    if kind == ITEM:
        _begin(state, items, times, node, about, max(time, state.nodes[node, Node.SERVER]))
        return
    if about == node:
        times.stops[node] = time
        return
    begin, interrupts = max(time, state.nodes[node, Node.SERVER]), state.nodes[node, Node.RUNS] != 0
    if state.nodes[node, Node.OWN] < state.nodes[node, Node.END]:
        state.nodes[node, Node.END] -= 1
        end = send(state, begin, node, about, _WORDS, ITEM, state.nodes[node, Node.END], 0)
    else:
        state.counts[about, Count.RING_HOPS] += 1
        end = send(state, begin, node, successor[node], _WORDS, RING, about, 0)
    serving(state, node, begin, end, interrupts)


@compiled
def _is_next(state, now, time):
    """Whether a program that is at ``now``, in an event of ``time``, is not ahead of other events."""
    return now == time or now < next_time(state.heap) or next_time(state.heap) < 0


@compiled
def _advance(state, items, references, times, successor, node, time, is_shared, is_read_only):
    """A program goes on until it faults, ends its item, or another event could change what it has.

    No event takes a page from a program if none writes. So it may be ahead of the other events, and faults when they
    have come up with it.
    """
    now, nodes = time, len(state.nodes)
    item = state.nodes[node, Node.CURRENT]
    first, end, work = items.first[item], items.first[item + 1], items.work[item]
    if first == end and state.nodes[node, Node.WORKED] == first:
        state.nodes[node, Node.WORKED] += 1
        now += work
    while state.nodes[node, Node.REFERENCE] < end:
        at = state.nodes[node, Node.REFERENCE]
        page, writes = references.pages[at] >> 1, references.pages[at] & 1
        if state.nodes[node, Node.WORKED] == at:
            state.nodes[node, Node.WORKED] += 1
            now += work * (at + 1 - first) // (end - first) - work * (at - first) // (end - first)
            if page % nodes != node:
                now += items.check[item]
        mode = state.mode[node, page]
        misses = mode == NONE or (writes and mode != WRITE)
        if (misses or not is_read_only) and not _is_next(state, now, time):
            push(state.heap, now, RUN, node)
            return
        if misses:
            fault(state, references, now, node, page, writes)
            return
        refer(state, references, node, page)
    if _is_next(state, now, time):
        times.ends[item] = now
        _next_item(state, items, times, successor, node, now, is_shared)
    else:
        push(state.heap, now, RUN, node)
