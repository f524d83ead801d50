"""Cluster memory: the resident set and the cache of a cluster, in front of main memory."""

from collections import deque
from collections.abc import Callable

from golden.engine.memsys.bus.cache import Cache
from radiosity.machines.paper.agenda import Agenda
from radiosity.machines.paper.paper_timing import PaperTiming

__all__ = ["ClusterMemory"]


class ClusterMemory:
    """A reference to a patch is looked up in the resident set, then in the cache, and then requested.

    A patch of the resident set that the host has not yet sent is awaited, and not requested. A cache line is filled at
    the reference.

    Parameters
    ----------
    agenda, timing
        The simulation, and latencies.
    named
        Numbers of the patches whose tags name the cluster, or None: it has no tags.
    resident
        Numbers of the resident patches.
    held
        Those of them that have arrived before; patches that arrive are added.
    cache
        The cache, or None.
    request
        Called with the number of a patch that is requested from main memory.

    Members
    -------
    residents, hits, misses
        Counts of references, by the level that has served them.
    held
        Numbers of the resident patches that have arrived.
    received, dropped
        Patches of the resident set or requested that have arrived, and those that the host has sent here and that are
        neither.
    """

    def __init__(self, agenda: Agenda, timing: PaperTiming, *, named: frozenset[int] | None,
                 resident: frozenset[int], held: set[int],
                 cache: Cache | None, request: Callable[[int], object]):
        self._agenda, self._timing, self._resident, self.held = agenda, timing, resident, held
        self._named, self._cache, self._request = named, cache, request
        # Actions that await patches, by patch; patches whose requests wait.
        self._awaited, self._waiting, self._outstanding = {}, deque(), 0
        self.residents = self.hits = self.misses = self.received = self.dropped = 0

    def names(self, patch: int) -> bool:
        """Whether a patch may have rays in the section; one that its tag does not send here has none."""
        return self._named is None or patch in self._named

    def refer(self, patch: int, ready: Callable, *arguments: object) -> None:
        """Refer to a patch, and act when its first vertex can be read.

        Of a patch there is one reference at a time.
        """
        if patch in self._resident:
            self.residents += 1
            if patch in self.held:
                self._agenda.at(self._agenda.now + self._timing.resident, ready, *arguments)
            else:
                self._awaited[patch] = ready, arguments
        elif self._cache is not None and self._cache.access([patch])[0][0]:
            self.hits += 1
            self._agenda.at(self._agenda.now + self._timing.cache, ready, *arguments)
        else:
            self.misses += 1
            self._awaited[patch] = ready, arguments
            self._waiting.append(patch)
            self._send()

    def accept(self, patch: int) -> None:
        """The host has sent a patch; one that is not of the resident set is dropped."""
        if patch not in self._resident:
            self.dropped += 1
            return
        self.held.add(patch)
        self._arrive(patch)

    def answer(self, patch: int) -> None:
        """A patch that has been requested arrives."""
        self._outstanding -= 1
        self._arrive(patch)
        self._send()

    def _arrive(self, patch):
        self.received += 1
        if patch in self._awaited:
            ready, arguments = self._awaited.pop(patch)
            self._agenda.at(self._agenda.now + self._timing.resident, ready, *arguments)

    def _send(self):
        while self._waiting and self._outstanding < self._timing.requests:
            self._outstanding += 1
            self._request(self._waiting.popleft())
