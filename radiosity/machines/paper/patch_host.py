"""Patch host: main memory at the root of the tree of switches; it pushes patches and answers requests for them."""

from collections import deque
from collections.abc import Callable, Iterable

from radiosity.machines.paper.agenda import Agenda
from radiosity.machines.paper.paper_timing import PaperTiming

__all__ = ["PatchHost"]


class PatchHost:
    """Requests ascend the tree, one a cycle on each link; patches descend it. A reply precedes a patch to push.

    All links are equally wide, and all patches come from the root. So a patch waits there alone: below it no link has
    more traffic than the root's. Switches forward it word by word (cut-through).

    Parameters
    ----------
    agenda, timing
        The simulation, and latencies.
    levels
        Levels of switches: 2^levels clusters.
    accept, answer
        Called with a cluster and a patch when its last word has arrived: one that was pushed, or requested.

    Members
    -------
    pushed, replies, link_words
        Counts: patches sent to all clusters of their tags, patches sent to one that has requested them, words over all
        links of the tree.
    busy
        Cycles of the link at the root.
    """

    def __init__(self, agenda: Agenda, timing: PaperTiming, *, levels: int,
                 accept: Callable[[int, int], object], answer: Callable[[int, int], object]):
        self._agenda, self._timing, self._levels = agenda, timing, levels
        self._accept, self._answer = accept, answer
        # The first cycle in which the root can send down; of each level that in which the link above a node is free.
        self._root, self._free = 0, [[0] * (1 << level) for level in range(levels + 1)]
        self._replies, self._pushes, self._is_serving = deque(), deque(), False
        self.pushed = self.replies = self.link_words = self.busy = 0

    def announce(self, links: Iterable[int]) -> int:
        """Send tags, a word each, over so many links each: when all clusters have them."""
        time = self._agenda.now
        for number in links:
            time = self._descend(number, words=1)
        return time

    def push(self, patch: int, clusters: Iterable[int], links: int) -> None:
        """Send a patch to clusters over so many links, when no reply waits."""
        self._pushes.append((patch, tuple(clusters), links))
        self._serve()

    def request(self, cluster: int, patch: int) -> None:
        """A cluster requests a patch now."""
        self._ascend(self._levels, cluster, cluster, patch)

    def _ascend(self, level, node, cluster, patch):
        start = max(self._agenda.now, self._free[level][node])
        self._free[level][node] = start + 1
        if level:
            self._agenda.at(start + self._timing.switch, self._ascend, level - 1, node >> 1, cluster, patch)
        else:
            self._agenda.at(start + self._timing.main, self._reply, cluster, patch)

    def _reply(self, cluster, patch):
        self._replies.append((patch, (cluster,), self._levels + 1))
        self._serve()

    def _serve(self):
        if self._is_serving:
            return
        if self._root > self._agenda.now:
            self._is_serving = True
            self._agenda.at(self._root, self._end)
            return
        if self._replies:
            (patch, clusters, links), deliver = self._replies.popleft(), self._answer
            self.replies += 1
        elif self._pushes:
            (patch, clusters, links), deliver = self._pushes.popleft(), self._accept
            self.pushed += 1
        else:
            return
        arrival = self._descend(links, words=self._timing.words)
        for cluster in clusters:
            self._agenda.at(arrival, deliver, cluster, patch)
        self._is_serving = True
        self._agenda.at(self._root, self._end)

    def _descend(self, links, *, words):
        """Send a packet over so many links: the cycle in which all its clusters have its last word."""
        self._root = max(self._agenda.now, self._root) + words
        self.busy += words
        self.link_words += words * links
        return self._root + self._levels * self._timing.switch

    def _end(self):
        self._is_serving = False
        self._serve()
