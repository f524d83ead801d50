"""The grid rays' version and presence: each is sent once per shell, and only one copy of it is under way.

Source: Shen 1993, Fig. 5.10 and section 5.3.4.4.
"""

import numpy as np

__all__ = ["RayMemory"]


class RayMemory:
    """Version (shell) and presence of each slot, and the requests that wait for an absent ray.

    A slot holds the grid ray of one row and column. The shells' grids have their own rows and columns, so where shells
    share a memory a slot's ray has another direction in each.

    Parameters
    ----------
    slots
        Size of the largest grid.
    deferred
        Requests that can wait.

    Members
    -------
    waiting
        The deferred requests, oldest first: (slot, subshell, shell).
    """

    def __init__(self, slots: int, *, deferred: int):
        self._shell = np.zeros(slots, dtype=np.int64)
        self._present = np.ones(slots, dtype=bool)
        self._room = deferred
        self.waiting: list[tuple[int, int, int]] = []

    def request(self, slots: np.ndarray, *, subshell: int, shell: int):
        """A subshell asks for rays, each slot at most once.

        A slot whose version is the shell is passed over; a present ray leaves, taking the shell as its version; an
        absent one is deferred.

        Returns
        -------
        tuple
            The slots whose rays leave, and how many of the slots were looked at: all of them, or those before the
            first that would have to wait without room.
        """
        other = self._shell[slots] != shell
        absent = np.flatnonzero(other & ~self._present[slots])
        room = self._room - len(self.waiting)
        looked_at = len(slots) if len(absent) <= room else int(absent[room])
        self.waiting += [(int(slot), subshell, shell) for slot in slots[absent[:room]]]
        leaving = slots[:looked_at][other[:looked_at] & self._present[slots[:looked_at]]]
        self._present[leaving] = False
        self._shell[leaving] = shell
        return leaving, looked_at

    def complete(self, slots: np.ndarray):
        """Rays have come back: they are present again, and the requests that waited for them are tried again.

        Returns
        -------
        list
            (slot, subshell, shell) of the rays that leave again, in the order of the requests.
        """
        self._present[slots] = True
        waiting, self.waiting = self.waiting, []
        leaving = []
        for slot, subshell, shell in waiting:
            if not self._present[slot]:
                self.waiting.append((slot, subshell, shell))
            elif self._shell[slot] != shell:
                self._present[slot], self._shell[slot] = False, shell
                leaving.append((slot, subshell, shell))
        return leaving
