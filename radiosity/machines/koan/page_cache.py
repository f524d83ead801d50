"""Page cache: frames for other nodes' pages, given to the page least recently used; a page being written is pinned."""

from golden.base.compiled import compiled
from radiosity.machines.koan.page_state import DROPPED, NONE, READ, WRITE, Count, Frame, Node, PageState

__all__ = ["discard", "note", "store", "touch"]


@compiled
def note(state: PageState, time: int, node: int, page: int, code: int) -> None:
    """Log what a page becomes in a node."""
    row = state.logged[0]
    if row < len(state.log):
        state.log[row, 0], state.log[row, 1], state.log[row, 2], state.log[row, 3] = time, node, page, code
    state.logged[0] += 1


@compiled
def _unlink(state, node, frame):
    older, newer = state.frames[node, frame, Frame.OLDER], state.frames[node, frame, Frame.NEWER]
    state.frames[node, older, Frame.NEWER], state.frames[node, newer, Frame.OLDER] = newer, older


@compiled
def _link_newest(state, node, frame):
    end = state.frames.shape[1] - 1
    newest = state.frames[node, end, Frame.OLDER]
    state.frames[node, frame, Frame.OLDER], state.frames[node, frame, Frame.NEWER] = newest, end
    state.frames[node, newest, Frame.NEWER] = state.frames[node, end, Frame.OLDER] = frame


@compiled
def touch(state: PageState, node: int, page: int) -> None:
    """A node refers to a page that it has."""
    frame = state.frame[node, page]
    if frame >= 0 and state.frames[node, frame, Frame.NEWER] != state.frames.shape[1] - 1:
        _unlink(state, node, frame)
        _link_newest(state, node, frame)


@compiled
def discard(state: PageState, time: int, node: int, page: int, code: int) -> None:
    """Discard a node's copy of a page, and free its frame in the cache."""
    state.mode[node, page] = NONE
    frame = state.frame[node, page]
    if frame >= 0:
        _unlink(state, node, frame)
        state.frames[node, frame, Frame.PAGE], state.frame[node, page] = -1, -1
        state.frames[node, frame, Frame.NEWER], state.nodes[node, Node.FREE] = state.nodes[node, Node.FREE], frame
    note(state, time, node, page, code)


@compiled
def store(state: PageState, time: int, node: int, page: int) -> int:
    """Find a frame for a page of another home.

    The page least recently used is dropped, if no frame is free. A page in write mode is skipped.

    Returns
    -------
    A page in write mode that has to be written back before, because all are; else -1.

    Source: Badouel 1991, section 3.1. It does not say what happens if all are being written.
    """
    end = state.frames.shape[1] - 1
    if state.nodes[node, Node.FREE] < 0:
        oldest = state.frames[node, end, Frame.NEWER]
        while oldest != end and state.mode[node, state.frames[node, oldest, Frame.PAGE]] == WRITE:
            oldest = state.frames[node, oldest, Frame.NEWER]
        if oldest == end:
            return state.frames[node, state.frames[node, end, Frame.NEWER], Frame.PAGE]
        state.counts[node, Count.DROPS] += 1
        discard(state, time, node, state.frames[node, oldest, Frame.PAGE], DROPPED)
    frame = state.nodes[node, Node.FREE]
    state.nodes[node, Node.FREE] = state.frames[node, frame, Frame.NEWER]
    state.frames[node, frame, Frame.PAGE], state.frame[node, page] = page, frame
    state.mode[node, page] = READ
    _link_newest(state, node, frame)
    return -1
