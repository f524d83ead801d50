"""Version and presence of the grid rays: each is issued once per shell, with at most one copy in flight.

Source: Shen 1993, Fig. 5.10 and section 5.3.4.4.
"""

import numpy as np

__all__ = ["RayMemory"]


class RayMemory:
    """Version (shell) and presence of each slot, and the requests that wait for an absent ray.

    A slot holds the grid ray of one row and column. Each shell has rows and columns of its own, so where shells share
    a memory the ray of a slot has another direction in each.

    Parameters
    ----------
    slots
        Grid rays of the largest grid.
    deferred
        Capacity of the deferred requests.

    Members
    -------
    waiting
        The deferred requests, oldest first: (slot, subshell, shell).
    """

    def __init__(self, slots: int, *, deferred: int):
        self._shell = np.zeros(slots, dtype=np.int64)
        self._present = np.ones(slots, dtype=bool)
        self._capacity = deferred
        self.waiting: list[tuple[int, int, int]] = []

    def request(self, slots: np.ndarray, *, subshell: int, shell: int):
        """Request rays for a subshell, each slot at most once.

        A slot whose version is the shell is skipped. A present ray is issued and takes the shell as its version. The
        request for an absent ray is deferred.

        Returns
        -------
        tuple
            The slots whose rays are issued, and how many of the slots were accepted: all, or those before the first
            that would exceed the capacity of deferred requests.
        """
        other = self._shell[slots] != shell
        absent = np.flatnonzero(other & ~self._present[slots])
        free = self._capacity - len(self.waiting)
        accepted = len(slots) if len(absent) <= free else int(absent[free])
        self.waiting += [(int(slot), subshell, shell) for slot in slots[absent[:free]]]
        issued = slots[:accepted][other[:accepted] & self._present[slots[:accepted]]]
        self._present[issued] = False
        self._shell[issued] = shell
        return issued, accepted

    def complete(self, slots: np.ndarray):
        """Return rays: they are present again, and the requests deferred for them are retried.

        Returns
        -------
        list
            (slot, subshell, shell) of the rays that are issued again, in the order of the requests.
        """
        self._present[slots] = True
        waiting, self.waiting = self.waiting, []
        issued = []
        for slot, subshell, shell in waiting:
            if not self._present[slot]:
                self.waiting.append((slot, subshell, shell))
            elif self._shell[slot] != shell:
                self._present[slot], self._shell[slot] = False, shell
                issued.append((slot, subshell, shell))
        return issued
