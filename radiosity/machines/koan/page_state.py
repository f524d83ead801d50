"""Page state: the pages of a shared memory in the memories of its nodes, their servers, and their programs."""

from typing import NamedTuple

import numpy as np

from radiosity.machines.common.columns import columns
from radiosity.machines.common.event_heap import EventHeap, event_heap
from radiosity.machines.common.hypercube import Hypercube, hypercube
from radiosity.machines.koan.page_timing import PageTiming

__all__ = ["DROPPED", "INVALIDATED", "NONE", "READ", "USED", "WRITE", "WRITTEN_BACK", "Count", "Frame", "Home", "Node",
           "PageState", "References", "Server", "page_state"]

NONE, READ, WRITE = range(3)
"""Modes of a page in a node."""

INVALIDATED, DROPPED, WRITTEN_BACK, USED = 3, 4, 5, 6
"""Further codes of the log: why a node discarded a page; that it made a reference, whose number stands for the page."""

Count = columns("Count", "REFERENCES REMOTE_REFERENCES FAULTS FETCHES DROPS WRITE_BACKS INVALIDATIONS ACKNOWLEDGEMENTS "
                "RECALLS PAGES_SENT RING_HOPS RING_REQUESTS INTERRUPTED")
"""What each node counts. Fetches are pages that arrived; interrupted is ns of its program."""

Frame = columns("Frame", "PAGE OLDER NEWER")
"""A frame: its page or -1, and its neighbours in the order of their last use. Entry F begins and ends it."""

Home = columns("Home", "HOLDER BUSY MISSING SERVED FIRST LAST")
"""A page at its home: the node that has it in write mode, or -1; whether a request is served, for how many answers it
waits, and of which node it is; the first and last node that wait, or -1."""

Node = columns("Node", "FREE FOLLOWING WRITES HAD CURRENT REFERENCE WORKED OWN END RUNS SERVER STOLEN")
"""A node: the first free frame, of a list through ``NEWER``; the node that waits behind it; whether it writes and had
the page when it faulted; its item, its next reference, references whose work is done; its first own item that has not
begun and the end of them; whether its program runs; when its server is free; ns of interruptions to make up for."""


class Server(NamedTuple):
    """Ns of a trap and of serving a message, whether servers interrupt no program, and words of a page's message."""

    trap: int
    serve: int
    is_offloaded: bool
    page_words: int


class References(NamedTuple):
    """R references of programs to pages, in the order of their items.

    Parameters
    ----------
    pages
        R int32: twice the number of the page, and 1 more if the reference writes.
    word, value
        R: the word of the page, and what is stored there or has been loaded; both empty if contents do not count.
    """

    pages: np.ndarray
    word: np.ndarray
    value: np.ndarray


class PageState(NamedTuple):
    """Arrays that compiled functions change; N nodes, P pages, F frames of a cache and W words of a page.

    The home of a page is its number mod N. A home has a frame for each of its pages, which is never given to another
    page; pages of other homes are in the cache.

    Parameters
    ----------
    mode, frame
        N x P: the mode of each page in each node, and its frame in the cache or -1.
    frames
        N x (F + 1) rows, see `Frame`.
    pages
        P rows, see `Home`.
    copies
        P x N bool: nodes that got the page since it was last written, known at its home.
    nodes
        N rows, see `Node`.
    cached, home
        Contents, N x (F + 1) x W and P x 2 x W: the last entries are those in flight to the node, or to the home.
    counts
        N rows, see `Count`.
    log
        L x 4: time, node, page, and its new mode, or why it was discarded.
    logged
        1 int64: rows that were to be logged, which may be more than L.
    timing
        Of servers.
    heap, cube
        Events and links.
    """

    mode: np.ndarray
    frame: np.ndarray
    frames: np.ndarray
    pages: np.ndarray
    copies: np.ndarray
    nodes: np.ndarray
    cached: np.ndarray
    home: np.ndarray
    counts: np.ndarray
    log: np.ndarray
    logged: np.ndarray
    timing: Server
    heap: EventHeap
    cube: Hypercube

    @property
    def counted(self) -> dict[str, np.ndarray]:
        """By name of `Count`, in lower case: N int64, those of now."""
        return {name.lower(): self.counts[:, column].copy() for column, name in enumerate(Count._fields)}


def page_state(*, nodes: int, pages: int, frames: int, page_bytes: int, timing: PageTiming, words: int = 0,
               log: int = 0) -> PageState:
    """Pages at their homes, which may read them, and empty caches.

    Parameters
    ----------
    nodes
        N, a power of two.
    pages
        P.
    frames
        F of each node, at least 1.
    page_bytes
        Bytes of a page.
    timing
        Of messages, faults and servers.
    words
        float64 contents of a page; 0 if contents do not count.
    log
        Rows of the log.
    """
    mode = np.zeros((nodes, pages), dtype=np.int8)
    mode[np.arange(pages) % nodes, np.arange(pages)] = READ
    of_frames = np.full((nodes, frames + 1, len(Frame)), -1)
    # The ring has entry F alone; frames are in the list of free ones.
    of_frames[:, :frames - 1, Frame.NEWER] = np.arange(1, frames)
    of_frames[:, frames, Frame.OLDER] = of_frames[:, frames, Frame.NEWER] = frames
    of_pages = np.full((pages, len(Home)), -1)
    of_pages[:, [Home.BUSY, Home.MISSING]] = 0
    of_nodes = np.zeros((nodes, len(Node)), dtype=np.int64)
    of_nodes[:, Node.FOLLOWING] = -1
    return PageState(
        mode=mode, frame=np.full((nodes, pages), -1, dtype=np.int32), frames=of_frames, pages=of_pages,
        copies=np.zeros((pages, nodes), dtype=np.bool_), nodes=of_nodes, cached=np.zeros((nodes, frames + 1, words)),
        home=np.zeros((pages, 2, words)), counts=np.zeros((nodes, len(Count)), dtype=np.int64),
        log=np.zeros((log, 4), dtype=np.int64), logged=np.zeros(1, dtype=np.int64),
        timing=Server(timing.trap, timing.serve, timing.is_offloaded, page_bytes // 4),
        # N nodes wait for a page each at most, which has a message to each node at most.
        heap=event_heap(2 * nodes * nodes + 16 * nodes + 64), cube=hypercube(nodes, timing))
