"""Page protocol: requests to a page's home, copies to read, one copy to write, and acknowledged invalidations."""

from golden.base.compiled import compiled
from radiosity.machines.common.event_heap import push
from radiosity.machines.common.hypercube import transfer
from radiosity.machines.koan.page_cache import discard, note, store, touch
from radiosity.machines.koan.page_state import (
    INVALIDATED,
    NONE,
    READ,
    USED,
    WRITE,
    WRITTEN_BACK,
    Count,
    Home,
    Node,
    PageState,
    References,
)

__all__ = ["RUN", "fault", "handle", "refer", "send", "serving"]

RUN, REQUEST, RECALL, INVALIDATE, ANSWER, DATA, WRITE_BACK, RING, ITEM = range(9)
"""Kinds of events: a program goes on, or a message arrives."""

_FLAGS = 2


@compiled
def send(state: PageState, time: int, source: int, target: int, words: int, kind: int, about: int, flag: int) -> int:
    """Send a message about a page or another number; when its sender has set it up."""
    ready = time + state.cube.setup
    end = transfer(state.cube, ready, source, target, words)
    nodes = len(state.nodes)
    push(state.heap, end, kind, (about * nodes + source) * nodes * _FLAGS + target * _FLAGS + flag)
    return ready


@compiled
def serving(state: PageState, node: int, begin: int, end: int, interrupts: bool) -> None:
    """A server works until ``end``, at the cost of the program that it interrupts, if one ran before."""
    state.nodes[node, Node.SERVER] = end
    if interrupts and not state.timing.is_offloaded:
        state.nodes[node, Node.STOLEN] += end - begin
        state.counts[node, Count.INTERRUPTED] += end - begin


@compiled
def refer(state: PageState, references: References, node: int, page: int) -> None:
    """A node refers to a page that it has in the mode for it, and goes on to its next reference."""
    touch(state, node, page)
    at = state.nodes[node, Node.REFERENCE]
    if len(references.word):
        frame, word = state.frame[node, page], references.word[at]
        contents = state.home[page, 0] if frame < 0 else state.cached[node, frame]
        if references.pages[at] & 1:
            contents[word] = references.value[at]
        else:
            references.value[at] = contents[word]
        note(state, -1, node, at, USED)
    state.nodes[node, Node.RUNS] = True
    state.counts[node, Count.REFERENCES] += 1
    state.counts[node, Count.REMOTE_REFERENCES] += page % len(state.nodes) != node
    state.nodes[node, Node.REFERENCE] += 1


@compiled
def _copy(source, target):
    for word in range(len(source)):
        target[word] = source[word]


@compiled
def _send_page(state, time, source, target, page, kind, flag):
    """Send a page from a node that has it."""
    frame = state.frame[source, page]
    contents = state.home[page, 0] if frame < 0 else state.cached[source, frame]
    _copy(contents, state.cached[target, -1] if kind == DATA else state.home[page, 1])
    state.counts[source, Count.PAGES_SENT] += 1
    return send(state, time, source, target, 1 + state.timing.page_words, kind, page, flag)


@compiled
def fault(state: PageState, references: References, time: int, node: int, page: int, writes: int) -> None:
    """A node without a page in the mode for its reference requests it, and stops until it has it."""
    home = page % len(state.nodes)
    state.counts[node, Count.FAULTS] += 1
    state.nodes[node, Node.RUNS] = False
    state.nodes[node, Node.WRITES], state.nodes[node, Node.HAD] = writes, state.mode[node, page] != NONE
    time += state.timing.trap
    if home == node:
        time = _proceed(state, references, _request(state, references, time, page, node), page)
    else:
        time = send(state, time, node, home, 1, REQUEST, page, 0)
    state.nodes[node, Node.SERVER] = max(state.nodes[node, Node.SERVER], time)


@compiled
def _request(state, references, time, page, node):
    """The home serves a request, or keeps it until it has served those before."""
    if state.pages[page, Home.BUSY]:
        if state.pages[page, Home.FIRST] < 0:
            state.pages[page, Home.FIRST] = node
        else:
            state.nodes[state.pages[page, Home.LAST], Node.FOLLOWING] = node
        state.pages[page, Home.LAST] = node
        return time
    state.pages[page, Home.BUSY], state.pages[page, Home.SERVED] = True, node
    nodes, holder = len(state.nodes), state.pages[page, Home.HOLDER]
    home = page % nodes
    if state.nodes[node, Node.WRITES]:
        for other in range(nodes):
            if state.copies[page, other] and other != node and other != home:
                state.pages[page, Home.MISSING] += 1
                state.counts[home, Count.INVALIDATIONS] += 1
                time = send(state, time, home, other, 1, INVALIDATE, page, 0)
    elif holder == home:
        state.mode[home, page], state.pages[page, Home.HOLDER] = READ, -1
        note(state, time, home, page, READ)
    elif holder >= 0:
        state.pages[page, Home.MISSING] = 1
        state.counts[home, Count.RECALLS] += 1
        time = send(state, time, home, holder, 1, RECALL, page, 0)
    return time if state.pages[page, Home.MISSING] else _grant(state, references, time, page)


@compiled
def _proceed(state, references, time, page):
    """The home serves those that wait for a page, as long as it need not wait itself."""
    while state.pages[page, Home.FIRST] >= 0 and not state.pages[page, Home.BUSY]:
        node = state.pages[page, Home.FIRST]
        state.pages[page, Home.FIRST], state.nodes[node, Node.FOLLOWING] = state.nodes[node, Node.FOLLOWING], -1
        time = _request(state, references, time, page, node)
    return time


@compiled
def _grant(state, references, time, page):
    """No other node stands against the request that is served: its node gets the page."""
    node = state.pages[page, Home.SERVED]
    home, writes = page % len(state.nodes), state.nodes[node, Node.WRITES]
    state.pages[page, Home.BUSY] = False
    if node == home:
        state.mode[node, page] = WRITE if writes else READ
        note(state, time, node, page, state.mode[node, page])
        refer(state, references, node, page)
        push(state.heap, time, RUN, node)
    elif state.nodes[node, Node.HAD] and state.copies[page, node]:
        time = send(state, time, home, node, 1, DATA, page, 0)
    else:
        time = _send_page(state, time, home, node, page, DATA, 1)
    if writes:
        state.pages[page, Home.HOLDER] = node
        state.copies[page, :] = False
        if node != home and state.mode[home, page] != NONE:
            discard(state, time, home, page, INVALIDATED)
    if node != home:
        state.copies[page, node] = True
    return time


@compiled
def _returned(state, time, page):
    """The home has a page again that another node had in write mode."""
    home = page % len(state.nodes)
    _copy(state.home[page, 1], state.home[page, 0])
    state.pages[page, Home.HOLDER], state.mode[home, page] = -1, READ
    note(state, time, home, page, READ)


@compiled
def _install(state, references, time, node, page, has_page):
    """A node gets the page that it has requested, or the right to write what it has, and makes its reference at once.

    Otherwise other nodes could invalidate the page before, again and again: a livelock.
    """
    if has_page:
        state.counts[node, Count.FETCHES] += 1
        pinned = store(state, time, node, page)
        if pinned >= 0:
            time = _send_page(state, time, node, pinned % len(state.nodes), pinned, WRITE_BACK, 1)
            state.counts[node, Count.WRITE_BACKS] += 1
            discard(state, time, node, pinned, WRITTEN_BACK)
            store(state, time, node, page)
        _copy(state.cached[node, -1], state.cached[node, state.frame[node, page]])
    if state.nodes[node, Node.WRITES]:
        state.mode[node, page] = WRITE
    note(state, time, node, page, state.mode[node, page])
    refer(state, references, node, page)
    push(state.heap, time, RUN, node)
    return time


@compiled
def handle(state: PageState, references: References, time: int, kind: int, subject: int) -> None:
    """A message about a page has arrived; the server of its target handles it when it is free.

    An owner that has to give a page back sends it home, and keeps a copy if another node reads. The home lets a writer
    write when all that had a copy have acknowledged that they have discarded it. A node that has dropped its copy
    acknowledges too: its home gets no message of the drop.
    """
    nodes = len(state.nodes)
    flag, node = subject % _FLAGS, subject // _FLAGS % nodes
    source, page = subject // _FLAGS // nodes % nodes, subject // _FLAGS // nodes // nodes
    begin, interrupts = max(time, state.nodes[node, Node.SERVER]), state.nodes[node, Node.RUNS] != 0
    end = begin + state.timing.serve
    if kind == REQUEST:
        end = _proceed(state, references, _request(state, references, end, page, source), page)
    elif kind == ANSWER:
        if flag:
            _returned(state, end, page)
        state.pages[page, Home.MISSING] -= 1
        if not state.pages[page, Home.MISSING]:
            end = _proceed(state, references, _grant(state, references, end, page), page)
    elif kind == WRITE_BACK:
        state.copies[page, source] = False
        _returned(state, end, page)
    elif kind == DATA:
        end = _install(state, references, end, node, page, flag)
    else:
        mode = state.mode[node, page]
        if kind == INVALIDATE:
            state.counts[node, Count.ACKNOWLEDGEMENTS] += 1
        if mode == WRITE:
            end = _send_page(state, end, node, source, page, ANSWER, 1)
        else:
            end = send(state, end, node, source, 1, ANSWER, page, 0)
        if kind == INVALIDATE and mode != NONE:
            discard(state, end, node, page, INVALIDATED)
        elif mode == WRITE:
            state.mode[node, page] = READ
            note(state, end, node, page, READ)
    serving(state, node, begin, end, interrupts)
